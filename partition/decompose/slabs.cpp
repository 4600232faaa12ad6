// PQR and bisection: both cut groups of items across an axis, level by level.
#include "partition/decompose/slabs.h"

#include <algorithm>
#include <limits>

#include "partition/communication/reduce.h"
#include "partition/decompose/inertia.h"
#include "partition/decompose/ordered_cuts.h"

namespace weft::partition {
namespace {

using meshing::Point;
using meshing::Vec;

constexpr Axes kCartesian{Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}};

/// Coordinates along the axes, exact for Cartesian ones.
std::vector<Point> turned(std::span<const Point> points, const Axes& axes) {
  std::vector<Point> result;
  result.reserve(points.size());
  for (const Point& p : points) result.push_back({dot(axes[0], p), dot(axes[1], p), dot(axes[2], p)});
  return result;
}

/// How far a tet reaches along an axis. Cut by this, tets on one side are all that lie below the cut: the
/// faces around a set of whole balls of vertices. Cut by centres, their interface is ragged, and has a
/// quarter more vertices.
std::uint64_t reach_key(const TetCorners& tet, const Vec& axis) {
  return ordered_key(std::max(std::max(dot(axis, tet[0]), dot(axis, tet[1])),
                              std::max(dot(axis, tet[2]), dot(axis, tet[3]))));
}

/// What the slabs of an axis are cut by.
void fill_keys(const WeightedItems& items, const Axes& axes, int axis, SlabDirections directions,
               std::vector<std::uint64_t>& keys) {
  const bool by_coordinate = axis == 0 && directions.coordinate;
  for (std::size_t i = 0; i < keys.size(); ++i)
    keys[i] = by_coordinate ? ordered_key(items.coordinates[i]) : reach_key(items.corners[i], axes[axis]);
}

}  // namespace

Slabs suitable_slabs(std::uint32_t n, const Vec& sides) {
  Slabs best{n, 1, 1};
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t p = n; p >= 1; --p) {
    if (n % p != 0) continue;
    for (std::uint32_t q = n / p; q >= 1; --q) {
      if (n / p % q != 0) continue;
      const std::uint32_t r = n / p / q;
      const double area =
          (p - 1.0) * sides.y * sides.z + (q - 1.0) * sides.x * sides.z + (r - 1.0) * sides.x * sides.y;
      if (area < least) best = {p, q, r}, least = area;
    }
  }
  return best;
}

Bricks pqr_decomposition(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains, Slabs slabs,
                         SlabDirections directions) {
  std::vector<std::uint32_t> groups(items.centres.size(), 0);
  const Axes axes =
      directions.principal_axes ? principal_axes(covariances(peers, items, groups, 1)[0]) : kCartesian;
  if (slabs[0] == 0 && directions.coordinate)
    slabs = {num_subdomains, 1, 1};
  else if (slabs[0] == 0)
    slabs =
        suitable_slabs(num_subdomains, group_boxes(peers, turned(items.centres, axes), groups, 1)[0].size());
  std::size_t num_groups = 1;
  std::vector<std::uint64_t> keys(groups.size());
  for (int axis = 0; axis < 3; ++axis) {
    fill_keys(items, axes, axis, directions, keys);
    const std::vector<std::uint32_t> equal(slabs[axis], 1);
    groups = cut_groups(peers, {keys, items.numbers, items.weights}, groups, {num_groups, equal});
    num_groups *= slabs[axis];
  }
  return {slabs, std::move(groups)};
}

Bisected bisect(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains,
                const std::function<bool(std::uint64_t, std::uint32_t)>& cut) {
  Bisected b{std::vector<std::uint32_t>(items.centres.size(), 0), {num_subdomains}};
  std::vector<std::uint64_t> keys(items.centres.size());
  for (;;) {
    std::vector<std::uint64_t> counts(b.sizes.size(), 0);
    for (const std::uint32_t g : b.groups) ++counts[g];
    counts = partition::sum(peers, counts);
    std::vector<std::vector<std::uint32_t>> shares;
    std::vector<std::uint32_t> sizes;
    for (std::size_t g = 0; g < counts.size(); ++g) {
      const std::uint32_t size = b.sizes[g];
      shares.push_back(size > 1 && cut(counts[g], size) ? std::vector{size / 2, size - size / 2}
                                                        : std::vector{size});
      sizes.insert(sizes.end(), shares.back().begin(), shares.back().end());
    }
    if (sizes.size() == b.sizes.size()) return b;
    const std::vector<Vec> axes =
        cutting_axes(peers, items, b.groups, static_cast<std::uint32_t>(b.sizes.size()));
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = reach_key(items.corners[i], axes[b.groups[i]]);
    b.groups = cut_groups(peers, {keys, items.numbers, items.weights}, b.groups, shares);
    b.sizes = std::move(sizes);
  }
}

std::vector<SubdomainId> bisection(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains) {
  const Bisected all =
      bisect(peers, items, num_subdomains, [](std::uint64_t, std::uint32_t) { return true; });
  return {all.groups.begin(), all.groups.end()};
}

}  // namespace weft::partition

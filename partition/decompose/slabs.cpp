// PQR and bisection: both cut groups of items across an axis, level by level.
#include "partition/decompose/slabs.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

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

using CutGroup = std::function<bool(std::uint64_t, std::uint32_t)>;

std::vector<std::uint64_t> count_items(Peers& peers, const Bisected& b) {
  std::vector<std::uint64_t> counts(b.sizes.size(), 0);
  for (const std::uint32_t g : b.groups) ++counts[g];
  return partition::sum(peers, counts);
}

/// All ranks cut all groups together, level by level.
Bisected bisect_together(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains,
                         const CutGroup& cut) {
  Bisected b{std::vector<std::uint32_t>(items.centres.size(), 0), {num_subdomains}};
  std::vector<std::uint64_t> keys(items.centres.size());
  for (;;) {
    const std::vector<std::uint64_t> counts = count_items(peers, b);
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

/// An item on its way to the rank that cuts its group.
struct HomeItem {
  std::uint64_t group;
  std::uint64_t weight, number;
  Point centre;
  TetCorners corners;
  meshing::SymTensor cut_tensor;
};

/// The rank that cuts a group on, ascending with the groups, so that all have about as many items; -1: it is
/// not cut any more.
std::vector<int> homes_of_groups(Peers& peers, const Bisected& b, const CutGroup& cut) {
  const std::vector<std::uint64_t> counts = count_items(peers, b);
  const auto is_open = [&](std::size_t g) { return b.sizes[g] > 1 && cut(counts[g], b.sizes[g]); };
  std::uint64_t all = 0, before = 0;
  for (std::size_t g = 0; g < counts.size(); ++g) all += is_open(g) ? counts[g] : 0;
  std::vector<int> homes(counts.size(), -1);
  for (std::size_t g = 0; g < counts.size(); ++g) {
    if (!is_open(g)) continue;
    const double middle = static_cast<double>(before) + 0.5 * static_cast<double>(counts[g]);
    const double share = middle / std::max(1.0, static_cast<double>(all));
    homes[g] = std::min(static_cast<int>(share * peers.ranks()), peers.ranks() - 1);
    before += counts[g];
  }
  return homes;
}

/// What has come of one group, as one rank's items.
Bisected bisect_at_home(std::span<const HomeItem* const> group_items, std::uint32_t size,
                        const CutGroup& cut) {
  std::vector<Point> centres;
  std::vector<TetCorners> corners;
  std::vector<std::uint64_t> weights, numbers;
  std::vector<meshing::SymTensor> cut_tensors;
  for (const HomeItem* t : group_items) {
    centres.push_back(t->centre);
    corners.push_back(t->corners);
    weights.push_back(t->weight);
    numbers.push_back(t->number);
    cut_tensors.push_back(t->cut_tensor);
  }
  SelfPeers alone;
  return bisect_together(alone, {centres, corners, weights, numbers, cut_tensors}, size, cut);
}

/// Groups cut at this rank.
struct CutAtHome {
  std::vector<std::vector<std::uint32_t>> parts;  ///< parts[r][i]: in its group, of what rank r has sent
  std::vector<std::uint32_t> sizes;               ///< of the parts, group after group
};

/// `mine`: the groups of which this is the home, ascending; some may have no items.
CutAtHome cut_at_home(const std::vector<std::vector<HomeItem>>& arrived, std::span<const std::uint32_t> mine,
                      const std::vector<std::uint32_t>& sizes, const CutGroup& cut) {
  struct Group {
    std::vector<const HomeItem*> items;
    std::vector<std::uint32_t> parts;
    std::size_t next = 0;
  };
  std::map<std::uint64_t, Group> groups;
  for (const std::uint32_t g : mine) groups[g];
  for (const auto& of_rank : arrived)
    for (const HomeItem& t : of_rank) groups[t.group].items.push_back(&t);
  CutAtHome result;
  for (auto& [g, group] : groups) {
    Bisected here = bisect_at_home(group.items, sizes[g], cut);
    group.parts = std::move(here.groups);
    result.sizes.insert(result.sizes.end(), here.sizes.begin(), here.sizes.end());
  }
  for (const auto& of_rank : arrived) {
    std::vector<std::uint32_t>& parts = result.parts.emplace_back();
    for (const HomeItem& t : of_rank) {
      Group& group = groups[t.group];
      parts.push_back(group.parts[group.next++]);
    }
  }
  return result;
}

/// The groups that are still to be cut go each to one rank, which goes on alone: three exchanges in place of
/// some ten a level. Their parts are what all ranks together would make.
void bisect_at_homes(Peers& peers, const WeightedItems& items, const CutGroup& cut, Bisected& b) {
  const std::vector<int> homes = homes_of_groups(peers, b, cut);
  if (std::ranges::all_of(homes, [](int home) { return home < 0; })) return;
  std::vector<std::vector<HomeItem>> to_each(static_cast<std::size_t>(peers.ranks()));
  std::vector<std::size_t> counts(to_each.size(), 0);
  for (const std::uint32_t g : b.groups)
    if (homes[g] >= 0) ++counts[homes[g]];
  for (std::size_t r = 0; r < counts.size(); ++r) to_each[r].reserve(counts[r]);
  for (std::size_t i = 0; i < b.groups.size(); ++i)
    if (const int home = homes[b.groups[i]]; home >= 0)
      to_each[home].push_back({b.groups[i], items.weights[i], items.numbers[i], items.centres[i],
                               items.corners[i], items.cut_tensors[i]});
  std::vector<std::uint32_t> groups_here;
  for (std::uint32_t g = 0; g < homes.size(); ++g)
    if (homes[g] == peers.rank()) groups_here.push_back(g);
  CutAtHome mine = cut_at_home(partition::all_to_all(peers, std::move(to_each)), groups_here, b.sizes, cut);
  const std::vector<std::vector<std::uint32_t>> parts = partition::all_to_all(peers, std::move(mine.parts));
  const std::vector<std::uint32_t> sizes = allgather_joined(peers, mine.sizes);

  std::vector<std::uint32_t> first, all_sizes;
  auto size = sizes.begin();
  for (std::size_t g = 0; g < homes.size(); ++g) {
    first.push_back(static_cast<std::uint32_t>(all_sizes.size()));
    if (homes[g] < 0) all_sizes.push_back(b.sizes[g]);
    for (std::uint32_t left = homes[g] < 0 ? 0 : b.sizes[g]; left > 0; left -= *size++)
      all_sizes.push_back(*size);
  }
  std::vector<std::size_t> answered(parts.size(), 0);
  for (std::uint32_t& g : b.groups) {
    const int home = homes[g];
    g = first[g] + (home < 0 ? 0 : parts[home][answered[home]++]);
  }
  b.sizes = std::move(all_sizes);
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

Bisected bisect(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains, const CutGroup& cut) {
  constexpr std::uint64_t kLeastAtHome = 500, kMostAtHome = 20'000;
  // With more, exchanges do not count, and items on their way would take 400 bytes each.
  constexpr std::uint64_t kMostOfRank = 100'000;
  const std::uint64_t all = partition::sum(peers, std::uint64_t{items.numbers.size()});
  const std::uint64_t share = all / static_cast<std::uint64_t>(peers.ranks());
  if (peers.ranks() == 1 || share > kMostOfRank) return bisect_together(peers, items, num_subdomains, cut);
  const std::uint64_t at_home = std::clamp(share, kLeastAtHome, kMostAtHome);
  Bisected b = bisect_together(peers, items, num_subdomains, [&](std::uint64_t count, std::uint32_t size) {
    return count > at_home && cut(count, size);
  });
  bisect_at_homes(peers, items, cut, b);
  return b;
}

std::vector<SubdomainId> bisection(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains) {
  const Bisected all =
      bisect(peers, items, num_subdomains, [](std::uint64_t, std::uint32_t) { return true; });
  return {all.groups.begin(), all.groups.end()};
}

}  // namespace weft::partition

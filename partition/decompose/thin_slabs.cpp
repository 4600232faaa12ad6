// Expected vertices on each cut between two slabs, and the number of slabs that follows.
#include "partition/decompose/thin_slabs.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/expectations.h"
#include "partition/communication/reduce.h"
#include "partition/decompose/tet_measures.h"

namespace weft::partition {
namespace {

/// A face of a tet. Plain data without padding.
struct Side {
  std::array<std::uint32_t, 3> vertices;  ///< ascending
  std::uint32_t brick;
  float area;
};

/// action(a, b) for the two sides of each face; the single ones stay, in order.
template <class Action>
void pair_up(std::vector<Side>& sides, const Action& action) {
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.vertices, a.brick, a.area) < std::tie(b.vertices, b.brick, b.area);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i + 1 == sides.size() || sides[i].vertices != sides[i + 1].vertices) {
      sides[kept++] = sides[i];
      continue;
    }
    action(sides[i], sides[i + 1]);
    ++i;
  }
  sides.resize(kept);
}

std::vector<Side> sides_of(const ItemFaces& faces, const std::vector<std::uint32_t>& bricks) {
  std::vector<Side> sides;
  sides.reserve(4 * bricks.size());
  for (std::size_t t = 0; t < bricks.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& f = meshing::kTetFaces[i];
      const auto& v = faces.vertices[t];
      sides.push_back({{v[f[0]], v[f[1]], v[f[2]]}, bricks[t], faces.areas[t][i]});
      std::sort(sides.back().vertices.begin(), sides.back().vertices.end());
    }
  return sides;
}

/// For the two sides of each face of the mesh, on one rank.
template <class Action>
void for_each_face(Peers& peers, const ItemFaces& faces, const std::vector<std::uint32_t>& bricks,
                   const Action& action) {
  std::vector<Side> sides = sides_of(faces, bricks);
  pair_up(sides, action);
  const auto ranks = static_cast<std::uint32_t>(peers.ranks());
  if (ranks == 1) return;
  std::vector<std::vector<Side>> to_each(ranks);
  for (const Side& side : sides) to_each[side.vertices[0] % ranks].push_back(side);
  sides.clear();
  for (const auto& part : partition::all_to_all(peers, to_each))
    sides.insert(sides.end(), part.begin(), part.end());
  pair_up(sides, action);
}

/// Entry i: the vertices wanted on the cut between slabs i and i + 1 of this axis.
using Cuts = std::vector<double>;

/// A face between slabs that are not neighbours lies in all cuts between them.
std::array<Cuts, 3> measure_cuts(Peers& peers, const ItemFaces& faces, const Bricks& bricks) {
  constexpr double kQuantum = 1.0 / (1 << 20), kMost = 1 << 20;  // of a face: sums of integers have no order
  const Slabs& slabs = bricks.slabs;
  const Slabs stride{slabs[1] * slabs[2], slabs[2], 1};
  const Slabs first{0, slabs[0], slabs[0] + slabs[1]};
  std::vector<std::int64_t> steps(std::size_t{first[2]} + slabs[2], 0);
  for_each_face(peers, faces, bricks.numbers, [&](const Side& a, const Side& b) {
    if (a.brick == b.brick) return;
    const double wanted = std::clamp(vertices_wanted(a.area, b.area), 0.5, kMost);  // it has some already
    const std::int64_t quanta = std::llround(wanted / kQuantum);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t i = a.brick / stride[axis] % slabs[axis], j = b.brick / stride[axis] % slabs[axis];
      steps[first[axis] + std::min(i, j)] += quanta;
      steps[first[axis] + std::max(i, j)] -= quanta;
    }
  });
  steps = sum(peers, steps);
  std::array<Cuts, 3> cuts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::int64_t quanta = 0;
    for (std::uint32_t i = 0; i + 1 < slabs[axis]; ++i)
      cuts[axis].push_back(static_cast<double>(quanta += steps[first[axis] + i]) * kQuantum);
  }
  return cuts;
}

/// The vertices on the cuts that are left when the slabs are merged to `to`, as evenly as whole slabs allow.
double on_cuts(const Cuts& cuts, std::uint32_t to) {
  double sum = 0;
  const std::size_t from = cuts.size() + 1;
  for (std::size_t slab = 1; slab < to; ++slab) sum += cuts[(slab * from + to - 1) / to - 1];
  return sum;
}

double on_all_cuts(const std::array<Cuts, 3>& cuts, const Slabs& to) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) sum += on_cuts(cuts[axis], to[axis]);
  return sum;
}

Slabs fewer_slabs(const std::array<Cuts, 3>& cuts, Slabs slabs, double most, std::uint32_t fewest) {
  for (;;) {
    double all = 0, greatest = 0;
    std::uint32_t* thinnest = nullptr;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double here = on_cuts(cuts[axis], slabs[axis]);
      all += here;
      if (slabs[axis] > fewest && here > greatest) greatest = here, thinnest = &slabs[axis];
    }
    if (all <= most || !thinnest) return slabs;
    *thinnest = std::max(fewest, *thinnest - std::max(1u, *thinnest / 8));
  }
}

}  // namespace

std::uint32_t fewest_slabs(std::uint64_t num_subdomains) {
  std::uint64_t fewest = 8;
  while (8 * fewest * fewest * fewest < 27 * num_subdomains) ++fewest;
  return static_cast<std::uint32_t>(fewest);
}

WorthwhileSlabs worthwhile_slabs(Peers& peers, const ItemFaces& faces, std::span<const double> complexities,
                                 const Bricks& bricks) {
  const std::uint64_t subdomains = num_bricks(bricks.slabs);
  const std::uint32_t fewest = fewest_slabs(subdomains);
  if (*std::max_element(bricks.slabs.begin(), bricks.slabs.end()) <= fewest) return {bricks.slabs};
  const double all = meshing::kVerticesPerComplexity * ordered_sum(peers, complexities);
  if (!(all > 0)) return {bricks.slabs};
  const std::array<Cuts, 3> cuts = measure_cuts(peers, faces, bricks);
  const Slabs left = fewer_slabs(cuts, bricks.slabs, kMostShared * all, fewest);
  // A cube of n vertices has n^(2/3) on each of six sides, each shared by two.
  const double cubes = 3 * std::cbrt(static_cast<double>(subdomains) / all);
  return {left, std::min(on_all_cuts(cuts, bricks.slabs) / all, 1.0),
          std::min(on_all_cuts(cuts, left) / all, 1.0), std::min(cubes, 1.0)};
}

}  // namespace weft::partition

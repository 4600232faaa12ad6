// Point location by walking, and log-Euclidean interpolation.
#include "meshing/metric/background.h"

#include <algorithm>
#include <limits>

#include "meshing/geometry/surface/curved_triangle.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {
namespace {

/// Negative coordinates set to zero and the rest scaled to sum to one: the closest simplex feature, nearly.
/// The middle where none is positive.
std::array<double, 4> clamped(std::array<double, 4> l) {
  double sum = 0;
  for (double& x : l) sum += x = std::max(x, 0.0);
  for (double& x : l) x = sum > 0 ? x / sum : 0.25;
  return l;
}

}  // namespace

Background::Background(const MeshData& mesh, std::span<const LogMetric> log_metrics, Adjacency adjacency)
    : adjacency_(std::move(adjacency)) {
  blocks_.push_back({.points = mesh.points.data(),
                     .log_metrics = log_metrics.data(),
                     .tets = mesh.tets.data(),
                     .neighbours = adjacency_.neighbours.data(),
                     .num_tets = static_cast<std::uint32_t>(mesh.tets.size())});
}

Background::Background(std::vector<BackgroundBlock> blocks)
    : bits_(BackgroundBlock::kBits), mask_(BackgroundBlock::kMostTets - 1), blocks_(std::move(blocks)) {
  for (std::uint32_t b = 0; b < blocks_.size(); ++b) blocks_[b].first_code = b << (bits_ + 2);
}

Background::Barycentric Background::barycentric(std::uint32_t tet, const Point& p) const {
  const Corners x = corners(tet);
  const Point &a = x[0], &b = x[1], &c = x[2], &d = x[3];
  const Vec u = b - a, w = c - a, z = d - a, q = p - a;
  const Vec wz = cross(w, z), uq = cross(u, q);
  const double det = dot(u, wz);
  if (!(det > std::numeric_limits<double>::min())) return barycentric_in_flat(tet, p);
  const double inverse = 1 / det;
  Barycentric l;
  l[1] = dot(q, wz) * inverse;
  l[2] = dot(uq, z) * inverse;
  l[3] = -dot(uq, w) * inverse;
  l[0] = 1 - l[1] - l[2] - l[3];
  return l;
}

/// A tet that is positive exactly but not in doubles. Beyond one of its faces: -1 there, so that a walk goes
/// on; otherwise its vertex nearest to `p`.
Background::Barycentric Background::barycentric_in_flat(std::uint32_t tet, const Point& p) const {
  const Corners corner = corners(tet);
  const std::array<Point, 4> x{corner[0], corner[1], corner[2], corner[3]};
  Barycentric l{};
  const auto nearest = std::ranges::min_element(x, {}, [&](const Point& q) { return norm2(q - p); });
  l[static_cast<std::size_t>(nearest - x.begin())] = 1;
  for (int f = 0; f < 4; ++f)
    if (orientation(x[kTetFaces[f][0]], x[kTetFaces[f][1]], x[kTetFaces[f][2]], p) < 0) l[f] -= 1;
  return l;
}

bool Background::walk(const Point& p, std::uint32_t& tet, Barycentric& l) const {
  // Rounding in flat tets may send the walk round in circles: a slightly outside point ends it.
  constexpr double kTolerance = 1e-10;
  constexpr int kMaxSteps = 1000000;
  std::uint32_t previous = kNoNeighbour;
  std::uint32_t random = 12345;
  for (int step = 0; step < kMaxSteps; ++step) {
    l = barycentric(tet, p);
    int way = -1;
    bool outside = false;
    random = random * 1664525u + 1013904223u;  // a random order of faces keeps the walk from cycling
    double most = -kTolerance;
    for (int i = 0; i < 4; ++i) {
      const int f = (i + static_cast<int>(random >> 30)) & 3;
      if (l[f] >= -kTolerance) continue;
      outside = true;
      const std::uint32_t n = neighbour(tet, f);
      if (n == kNoNeighbour || n >> 2 == previous) continue;
      if (step > 200 ? way < 0 : l[f] < most) {
        way = f;
        most = l[f];
      }
    }
    if (!outside) return true;
    if (way < 0) return false;
    previous = tet;
    tet = neighbour(tet, way) >> 2;
  }
  return false;
}

LogMetric Background::interpolate(std::uint32_t tet, const Barycentric& l) const {
  const BackgroundBlock& block = block_of(tet);
  const auto& v = block.tets[tet & mask_];
  const LogMetric* at = block.log_metrics;
  return l[0] * at[v[0]] + l[1] * at[v[1]] + l[2] * at[v[2]] + l[3] * at[v[3]];
}

Point Background::closest_in(std::uint32_t tet, const Point& p) const {
  const Barycentric inside = barycentric(tet, p);
  if (*std::min_element(inside.begin(), inside.end()) >= 0) return p;
  const Corners corner = corners(tet);
  Point closest;
  double least = std::numeric_limits<double>::infinity();
  for (int f = 0; f < 4; ++f) {
    if (inside[f] >= 0) continue;  // the closest point lies on a face that p is beyond
    std::array<Point, 3> x;
    for (int i = 0; i < 3; ++i) x[i] = corner[static_cast<std::size_t>(kTetFaces[f][i])];
    const TrianglePoint q = closest_point(x[0], x[1], x[2], p);
    if (q.distance2 >= least) continue;
    least = q.distance2;
    closest = q.at[0] * x[0] + q.at[1] * x[1] + q.at[2] * x[2];
  }
  return closest;
}

Box Background::box_of(std::uint32_t tet) const {
  Box box;
  const Corners corner = corners(tet);
  for (std::size_t i = 0; i < 4; ++i) box.include(corner[i]);
  return box;
}

const ClosestForest& Background::tree_of_blocks() const {
  std::call_once(blocks_tree_.built, [&] {
    trees_ = std::make_unique<Tree[]>(blocks_.size());
    std::vector<ClosestForest::Item> items(blocks_.size());
    for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
      items[b].id = b;
      for (std::uint32_t t = 0; t < blocks_[b].num_tets; ++t) items[b].box.unite(box_of((b << bits_) + t));
    }
    blocks_tree_.forest.add(items);
  });
  return blocks_tree_.forest;
}

const ClosestForest& Background::tree_of(std::uint32_t block) const {
  constexpr std::ptrdiff_t kTetsOfLeaf = 16;  // few points are searched for so, and the tets are many
  Tree& tree = trees_[block];
  std::call_once(tree.built, [&] {
    std::vector<ClosestForest::Item> items(blocks_[block].num_tets);
    for (std::uint32_t t = 0; t < items.size(); ++t) {
      items[t].id = (block << bits_) + t;
      items[t].box = box_of(items[t].id);
    }
    tree.forest.add(items, kTetsOfLeaf);
  });
  return tree.forest;
}

std::uint32_t Background::search_everywhere(const Point& p) const {
  std::uint32_t closest = 0;
  double least = std::numeric_limits<double>::infinity();
  const auto look_at = [&](std::uint32_t tet) {
    const double distance2 = norm2(p - closest_in(tet, p));
    if (distance2 >= least) return;
    least = distance2;
    closest = tet;
  };
  tree_of_blocks().visit_within(
      0, p, least, [&](std::uint32_t block) { tree_of(block).visit_within(0, p, least, look_at); });
  return closest;
}

/// The walk has ended at the boundary in `tet`. Within half a unit length the metric hardly changes; farther
/// off, the point may lie beyond a gap (the other side of a thin body), or outside a curved boundary.
Background::Sample Background::outside(const Point& p, std::uint32_t tet) const {
  for (int attempt = 0;; ++attempt) {
    const Point q = closest_in(tet, p);
    const LogMetric l = interpolate(tet, clamped(barycentric(tet, q)));
    if (attempt > 0 || squared_length(exp_fast(l), p - q) < 0.25) return {l, tet};
    tet = search_everywhere(p);
  }
}

Background::WalkEnd Background::walk_towards(const Point& p, std::uint32_t hint) const {
  WalkEnd end{hint == kNoHint ? 0 : hint, false};
  Barycentric l;
  end.reached = walk(p, end.tet, l);
  return end;
}

Background::Sample Background::at(const Point& p, std::uint32_t hint) const {
  std::uint32_t tet = hint == kNoHint ? 0 : hint;
  Barycentric l;
  if (!walk(p, tet, l)) return outside(p, tet);
  return {interpolate(tet, clamped(l)), tet};
}

}  // namespace weft::meshing

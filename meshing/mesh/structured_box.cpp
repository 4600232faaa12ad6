// Cuts the cells of a box into tets, with the cells' diagonals running away from the box's corners.
#include "meshing/mesh/structured_box.h"

#include <array>
#include <cmath>
#include <utility>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace {

using Index3 = std::array<std::uint32_t, 3>;

/// The six orders in which a path from a cell's first to its last corner takes the axes; the first three are
/// even.
constexpr std::array<std::array<int, 3>, 6> kAxisOrders = {
    {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};

class BoxBuilder {
 public:
  explicit BoxBuilder(const BoxOptions& options) : options_(options) {}

  MeshData build() {
    add_points();
    add_tets();
    add_box_edges();
    add_corners();
    return std::move(mesh_);
  }

 private:
  std::uint32_t cells(int axis) const { return options_.cells[static_cast<std::size_t>(axis)]; }

  std::uint32_t vertex(const Index3& i) const {
    return i[0] + (cells(0) + 1) * (i[1] + (cells(1) + 1) * i[2]);
  }

  /// Exactly the box's face at both ends: planarity and areas are compared at rounding level.
  double coordinate(int axis, std::uint32_t i) const {
    if (i == cells(axis)) return options_.max[axis];
    return options_.min[axis] + (options_.max[axis] - options_.min[axis]) * i / cells(axis);
  }

  void add_points() {
    for (std::uint32_t k = 0; k <= cells(2); ++k)
      for (std::uint32_t j = 0; j <= cells(1); ++j)
        for (std::uint32_t i = 0; i <= cells(0); ++i)
          mesh_.points.push_back({coordinate(0, i), coordinate(1, j), coordinate(2, k)});
    mesh_.point_refs.assign(mesh_.points.size(), 0);
  }

  void add_tets() {
    mesh_.tets.reserve(std::size_t{6} * cells(0) * cells(1) * cells(2));
    for (std::uint32_t k = 0; k < cells(2); ++k)
      for (std::uint32_t j = 0; j < cells(1); ++j)
        for (std::uint32_t i = 0; i < cells(0); ++i) add_cell({i, j, k});
    mesh_.tet_refs.assign(mesh_.tets.size(), 1);
  }

  /// Six tets around the cell's diagonal. Cells in the upper half of an axis are mirrored, which leaves their
  /// common faces alike and makes every diagonal start at the cell's corner nearest to a box corner: then
  /// every box edge has two tets, and none is stuck in the angle between two faces.
  void add_cell(const Index3& cell) {
    Index3 first = cell, last = cell;
    bool mirrored = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool flip = 2 * cell[axis] + 1 > options_.cells[axis];
      ++(flip ? first : last)[axis];
      mirrored ^= flip;
    }
    for (std::size_t o = 0; o < kAxisOrders.size(); ++o) {
      std::array<Index3, 4> path = {first, first, first, last};
      path[1][kAxisOrders[o][0]] = path[2][kAxisOrders[o][0]] = last[kAxisOrders[o][0]];
      path[2][kAxisOrders[o][1]] = last[kAxisOrders[o][1]];
      const bool even = o < 3;
      if (even == mirrored) std::swap(path[2], path[3]);
      add_tet(path);
    }
  }

  void add_tet(const std::array<Index3, 4>& corners) {
    // Face i is opposite vertex i and seen from outside.
    static constexpr std::array<std::array<int, 3>, 4> kFaces = {
        {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    mesh_.tets.push_back({vertex(corners[0]), vertex(corners[1]), vertex(corners[2]), vertex(corners[3])});
    for (const auto& face : kFaces) {
      const Index3 &a = corners[face[0]], &b = corners[face[1]], &c = corners[face[2]];
      if (const int ref = box_face(a, b, c)) {
        mesh_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
        mesh_.triangle_refs.push_back(ref);
      }
    }
  }

  /// Reference of the box face that holds all three points, 0 when there is none.
  int box_face(const Index3& a, const Index3& b, const Index3& c) const {
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      if (a[at] != b[at] || a[at] != c[at]) continue;
      if (a[at] == 0) return 2 * axis + 1;
      if (a[at] == cells(axis)) return 2 * axis + 2;
    }
    return 0;
  }

  void add_box_edges() {
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 4; ++side) add_box_edge(axis, side);
  }

  void add_box_edge(int axis, int side) {
    const int second = (axis + 1) % 3, third = (axis + 2) % 3;
    Index3 from{};
    from[static_cast<std::size_t>(second)] = side & 1 ? cells(second) : 0;
    from[static_cast<std::size_t>(third)] = side & 2 ? cells(third) : 0;
    for (std::uint32_t i = 0; i < cells(axis); ++i) {
      Index3 to = from;
      ++to[static_cast<std::size_t>(axis)];
      mesh_.ridges.push_back(static_cast<std::uint32_t>(mesh_.edges.size()));
      mesh_.edges.push_back({vertex(from), vertex(to)});
      mesh_.edge_refs.push_back(4 * axis + side + 1);
      from = to;
    }
  }

  void add_corners() {
    for (std::uint32_t corner = 0; corner < 8; ++corner)
      mesh_.corners.push_back(
          vertex({corner & 1 ? cells(0) : 0, corner & 2 ? cells(1) : 0, corner & 4 ? cells(2) : 0}));
  }

  const BoxOptions& options_;
  MeshData mesh_;
};

void check(const BoxOptions& options) {
  constexpr double kMaxTets = 4e9;  // 32-bit indices
  double tets = 6;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t cells = options.cells[static_cast<std::size_t>(axis)];
    if (cells == 0) throw InputError("", "box", "needs at least one cell in every direction");
    tets *= cells;
    const double extent = options.max[axis] - options.min[axis];
    if (!(extent > 0) || !std::isfinite(extent))
      throw InputError("", "box", "its maximum must lie above its minimum in every direction");
  }
  if (tets > kMaxTets) throw InputError("", "box", "more than 4e9 tets do not fit 32-bit indices");
}

}  // namespace

MeshData structured_box(const BoxOptions& options) {
  check(options);
  return BoxBuilder(options).build();
}

}  // namespace weft::meshing

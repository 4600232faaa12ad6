// Triangles that go through each other, cut along the lines where they meet.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/initial/mending/listed_edges.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct SplitTriangles {
  std::vector<Point> points;  ///< those given, then the new ones, rounded
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> parent;  ///< of each triangle: which given one it is a piece of
  EdgeCuts cuts;                      ///< of the given triangles' edges
};

/// Cuts the triangles of each pair (from self_intersections()) along what they have in common. All is exact
/// but the coordinates of new points, which are rounded last: pieces can cross anew by that little. Triangles
/// beside a cut edge are cut with it. None may be degenerate, no two points equal. The order of the result
/// depends on nothing but the input. Throws Interrupted once the flag, if any, is set.
SplitTriangles split_crossings(std::span<const Point> points, std::span<const Triangle> triangles,
                               std::span<const std::array<std::uint32_t, 2>> pairs,
                               const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing

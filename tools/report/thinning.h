// Triangles made fewer by joining vertices in the cells of grids.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "meshing/base/box.h"

namespace weft::report {

using Corner = std::array<float, 3>;

/// Triangles as points and three indices of these each.
struct Triangles {
  std::vector<Corner> points;
  std::vector<std::array<std::uint32_t, 3>> corners;

  /// With points of its own.
  void add(const std::array<Corner, 3>& triangle) {
    const auto first = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), triangle.begin(), triangle.end());
    corners.push_back({first, first + 1, first + 2});
  }
  std::array<Corner, 3> at(std::size_t triangle) const {
    const auto& [a, b, c] = corners[triangle];
    return {points[a], points[b], points[c]};
  }
};

/// What is left of some triangles, and what became of each.
struct Thinning {
  Triangles left;                      ///< in the order of the first that each stands for
  std::vector<std::uint32_t> kept;     ///< ascending: those that have not collapsed
  std::vector<std::uint32_t> in_left;  ///< of each of `kept`: the one of `left` that stands for it
  bool thinned = false;                ///< whether any were too many
};

/// Joins points on grids of `box`, coarser and coarser, until no more than `most` triangles are left: the
/// first point met in a cell stands for all of it, triangles that collapse go, equal ones become one. Linear
/// time; the number of grids grows with the logarithm of what is too much.
Thinning thinned_out(Triangles triangles, const meshing::Box& box, std::size_t most);

}  // namespace weft::report

// The common part of two tets, in pieces that carry barycentric coordinates in both.
#pragma once

#include <array>
#include <vector>

#include "meshing/base/point.h"

namespace weft::meshing {

/// A tet within two others: its corners in the barycentric coordinates of both.
struct OverlapPiece {
  struct Corner {
    std::array<double, 4> in_first, in_second;
  };
  std::array<Corner, 4> corners;
  double volume = 0;  ///< never negative
};

/// Adds to `pieces` tets that fill the common part of two positively oriented tets. Their volumes are
/// products of ratios, so that they add up to rounding however thin the pieces are; coordinates along the way
/// are convex combinations. Empty where the tets only touch. Up to 1 us; allocates only while `pieces` grows.
void overlap(const std::array<Point, 4>& first, const std::array<Point, 4>& second,
             std::vector<OverlapPiece>& pieces);

}  // namespace weft::meshing

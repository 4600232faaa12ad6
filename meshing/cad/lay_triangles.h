// Triangles of a face that stand on it, or are a line, give way by flips.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

/// A triangle of a model's face, its corners with their parameters.
struct FaceTriangle {
  std::array<std::uint32_t, 3> v;
  std::array<Parameters, 3> at;
};

/// Lower vertex first.
using VertexPair = std::pair<std::uint32_t, std::uint32_t>;

/// Tessellations connect points in the plane of the parameters: there a fan from a pole to the points of a
/// meridian has area, in space it is a line (on a cone) or stands on the surface (on a sphere). Flips edges
/// where the worse of two triangles, seen along the surface's normal, becomes better; never the edges
/// `fixed`. `poles`: vertices whose parameters mean nothing.
void lay_triangles(const GeometryModel& model, std::uint32_t face, std::span<const Point> points,
                   const std::set<VertexPair>& fixed, const std::set<std::uint32_t>& poles,
                   std::vector<FaceTriangle>& triangles);

}  // namespace weft::meshing

// The geometric half of the reference geometry: planes of planar patches, lines of straight curves, and the
// control points that make the rest of the triangulation a curved surface.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/geometry/surface.h"
#include "meshing/geometry/surface_topology.h"

namespace weft::meshing {

struct Plane {
  Point point;
  Vec normal;           ///< unit; components below 1e-12 are zero
  double rounding = 0;  ///< 1e-12 of the patch's diameter
};

struct Line {
  Point point;
  Vec direction;        ///< unit; components below 1e-12 are zero
  double rounding = 0;  ///< 1e-12 of the curve's length
};

struct SurfaceShape {
  std::vector<Patch> patches;
  std::vector<Plane> planes;  ///< patch -> plane; of planar ones
  std::vector<Line> lines;    ///< curve -> line; of straight ones
  /// Edge -> its inner Bezier control points, relative to its lower and its upper end. Kept by edge rather
  /// than computed from normals, so that all triangles at an edge agree to the last bit.
  std::vector<std::array<Vec, 2>> handles;
};

/// Sets `straight` of the topology's curves. O(n).
SurfaceShape build_surface_shape(std::span<const Point> points, SurfaceTopology& topology);

}  // namespace weft::meshing

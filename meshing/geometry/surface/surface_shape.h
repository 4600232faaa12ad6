// The geometric half of the reference geometry: planes of planar patches, and the control points that make
// the rest of the triangulation a curved surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/fixed_point_sum.h"
#include "meshing/base/point.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_curves.h"
#include "meshing/geometry/surface/surface_topology.h"

namespace weft::meshing {

struct Plane {
  Point point;
  Vec normal;           ///< unit; components below 1e-12 are zero
  double rounding = 0;  ///< 1e-12 of the patch's diameter
};

/// What is found of the patches' planes by looking at the triangles three times. Each step's results of parts
/// of a surface, by patch, add up to those of the whole, the same bits in any order.
struct PatchExtent {
  Box box;
  double greatest = 0;                   ///< coordinate of a triangle's normal as long as twice its area
  std::uint32_t first_triangle = kNone;  ///< in the whole mesh
  std::uint32_t unused = 0;              ///< no byte of a message is undefined
  Point reference;                       ///< a corner of that triangle
  void add(const PatchExtent& other);
};
struct PatchSums {
  std::array<FixedPointSum, 4> sums;  ///< the normals' coordinates, and their lengths
  void add(const PatchSums& other);
};
struct PatchHeights {
  double lo = 0, hi = 0;  ///< over the plane through the reference
  void add(const PatchHeights& other);
};

class PlaneFits {
 public:
  PlaneFits(std::span<const Point> points, const SurfaceTopology& topology) : points_(points), s_(topology) {}

  /// Of own triangles, `numbers` of which tell their places in the whole mesh (empty: as here).
  std::vector<PatchExtent> extents(std::span<const std::uint32_t> numbers) const;
  /// With all parts' extents.
  std::vector<PatchSums> sums(std::span<const PatchExtent> extents) const;
  std::vector<PatchHeights> heights(std::span<const Plane> planes) const;

 private:
  std::span<const Point> points_;
  const SurfaceTopology& s_;
};

/// Through the reference points.
std::vector<Plane> planes_of(std::span<const PatchExtent> extents, std::span<const PatchSums> sums);
/// Moves the planes amid the heights, and says which patches are planar.
std::vector<Patch> patches_of(std::span<const std::int32_t> refs, std::span<const PatchExtent> extents,
                              std::span<const PatchSums> sums, std::span<const PatchHeights> heights,
                              std::vector<Plane>& planes);

/// Edge -> its inner Bezier control points, relative to its lower and its upper end; of the edges of own
/// triangles. Kept by edge rather than computed from normals, so that all triangles at an edge agree to the
/// last bit. Empty where all patches are planar and all curves straight. The topology's fans get better
/// normals. O(n).
std::vector<std::array<Vec, 2>> control_points(std::span<const Point> points, std::span<const Patch> patches,
                                               std::span<const Curve> curves, SurfaceTopology& topology);

}  // namespace weft::meshing

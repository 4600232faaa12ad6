// Does a boundary triangle stay near the reference surface?
#pragma once

#include <array>
#include <vector>

#include "meshing/kernel/kernel.h"
#include "weft/data.h"

namespace weft::meshing {

/// Must boundary edge (a, b) of a curved `patch` be split? Its middle is farther than Kernel::hausd from the
/// reference surface (or curve), or the edge is longer than limits.finest_long_edge and the way from its
/// middle to the surface longer than limits.largest_bulge in the metric, or than that over an arc of 30
/// degrees: a vertex put there would be pushed through the tets upon it once they are thin. Both ends must be
/// claimed.
bool curves_too_much(const Kernel& k, VertexId a, VertexId b, PatchId patch);

/// How far the middle of boundary edge (a, b) is from the reference surface (or curve).
double edge_deviation(const Kernel& k, VertexId a, VertexId b, PatchId patch);

/// May triangle `changed` of a curved patch take the place of `old`? Its new edges must not curve too much,
/// its centroid lie within Kernel::hausd of the reference surface, and its normal turn by less than 60
/// degrees from the surface's and from the old one's. What deviates no more than `before`, as the boundary
/// does already, is near enough. All vertices must be claimed.
bool fits_surface(const Kernel& k, PatchId patch, const std::array<VertexId, 3>& changed,
                  const std::array<VertexId, 3>& old, double before = 0);

/// Distance from the centroid of a boundary face to the reference surface of `patch`.
double surface_deviation(const TetMesh& mesh, const Surface& surface, PatchId patch, TetId t, int face);
/// The largest of all boundary triangles; 0 where the boundary is planar.
double largest_surface_deviation(const TetMesh& mesh, const Surface& surface);

/// Where the surface needs shorter edges than the metric asks for: by reference, most edges first.
std::vector<SurfaceDemand> surface_demands(const Kernel& k);

}  // namespace weft::meshing

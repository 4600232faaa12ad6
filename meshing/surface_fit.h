// Does a boundary triangle stay near the reference surface?
#pragma once

#include <array>

#include "meshing/kernel.h"

namespace weft::meshing {

/// True when the triangle `changed` of a curved patch deviates at most limits.hausd from the reference surface at its
/// centroid and edge middles and its normal turns by less than 60 degrees from that of `old`, the triangle it replaces.
/// All vertices must be claimed.
bool fits_surface(const Kernel& k, PatchId patch, const std::array<VertexId, 3>& changed, const std::array<VertexId, 3>& old);

/// Length in the metric of the way from the middle of boundary edge (a, b) to the reference surface of `patch` (or to the
/// curve of a feature edge): what a vertex put there would push into the tets around. Both ends must be claimed.
double bulge(const Kernel& k, VertexId a, VertexId b, PatchId patch);

/// Distance of point `p` near vertex `near` from the reference surface of `patch`.
double surface_distance(const Kernel& k, PatchId patch, const Point& p, VertexId near);

}  // namespace weft::meshing

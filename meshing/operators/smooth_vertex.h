// Vertex moves: a Newton step on the ball's quality, and a Ceres-based relocation where that fails.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// One damped Newton step of vertex `v` on the sum of inverse mean ratios of its ball, along what its
/// classification allows (curve, patch, space). Taken when the sum falls and the worst tet gets no worse,
/// with the metric read at the new place.
Verdict smooth_vertex(Worker& w, VertexId v);

/// Where smoothing is stuck: minimises the sum of 1/Q^4 over the ball (nearly the worst tet alone) by
/// Levenberg-Marquardt, Ceres' TinySolver. Taken when the worst tet gets better. Interior vertices only.
Verdict relocate_vertex(Worker& w, VertexId v);

}  // namespace weft::meshing

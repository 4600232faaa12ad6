// Relocation: a vertex that smoothing cannot help is moved by a solver.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// Where smoothing is stuck: minimises the sum of 1/Q^4 over the ball (nearly the worst tet alone) by
/// Levenberg-Marquardt, Ceres' TinySolver. Taken when the worst tet gets better. Interior vertices only.
Verdict relocate_vertex(Worker& w, VertexId v);

}  // namespace weft::meshing

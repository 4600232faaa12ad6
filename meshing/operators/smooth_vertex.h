// Smoothing: a Newton step of one vertex on the quality of its ball.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// One damped Newton step of vertex `v` on the sum of inverse mean ratios of its ball, along what its
/// classification allows (curve, patch, space). Taken when the sum falls and the worst tet gets no worse,
/// with the metric read at the new place.
Verdict smooth_vertex(Worker& w, VertexId v);

/// The same of the centre of the gathered ball, which is not frozen. The ball stays gathered.
Verdict smooth_gathered(Worker& w);

}  // namespace weft::meshing

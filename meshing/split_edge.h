// Edge split: a vertex is created on an edge and every tet of the shell becomes two.
#pragma once

#include "meshing/kernel.h"

namespace weft::meshing {

/// Splits edge (a, b) of the claimed tet `t` at its middle in the metric; on curved boundary the new vertex is put
/// on the reference surface. Refuses what would invert, create an edge shorter than `shortest` or a tet worse than
/// limits.split_quality. All touched vertices stay claimed; the caller releases.
Verdict split_edge(Worker& w, TetId t, VertexId a, VertexId b, double shortest);

}  // namespace weft::meshing

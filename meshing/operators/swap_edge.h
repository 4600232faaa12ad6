// Edge swap: the tets of a shell are replaced by better ones.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

inline constexpr int kMaxRing = 9;

/// Replaces the shell of edge (a, b) of the claimed tet `t` by the triangulation of its ring whose worst tet
/// is best (dynamic programming after Klincsek 1980, over all triangulations of rings of up to kMaxRing
/// vertices), if that is better than the worst tet now. Edges on the boundary are swapped within a smooth
/// patch; feature edges never.
Verdict swap_edge(Worker& w, TetId t, VertexId a, VertexId b);

/// Every tet of a shell would try the same swap: it is left to a worse one that is going to be visited.
inline bool leaves_swap_to(const TetMesh& mesh, TetId t, TetId other) {
  return mesh.quality(other) < mesh.quality(t) && mesh.marks(other) & kCheckSwap;
}

}  // namespace weft::meshing

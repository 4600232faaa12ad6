// What edge swaps and face swaps share.
#pragma once

#include <algorithm>

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// A swap must improve the worst tet by more than rounding, lest two swaps undo each other for ever.
inline double enough_for_swap(double old_worst) { return old_worst + std::max(1e-3, 0.01 * old_worst); }

/// A face of the hole that removed tets leave: the outer neighbour and the patch it had.
struct OuterFace {
  TetFace neighbour;
  PatchId patch;
};
inline OuterFace outer_face(const TetMesh& mesh, TetId t, int face) {
  return {mesh.neighbour(t, face), mesh.patch(t, face)};
}

/// A new edge may be short.
inline void mark_if_short(const Worker& w, VertexId a, VertexId b) {
  if (!edge_between(w.mesh, a, b).below(w.kernel.limits.short_edge)) return;
  w.mesh.mark(a, kCheckShort);
  w.mesh.mark(b, kCheckShort);
}

}  // namespace weft::meshing

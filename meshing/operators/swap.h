// Edge and face swaps: the tets of a shell, or two tets across a face, are replaced by better ones.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// Replaces the shell of edge (a, b) of the claimed tet `t` by the triangulation of its ring whose worst tet
/// is best (dynamic programming after Klincsek 1980, over all triangulations of rings of up to kMaxRing
/// vertices), if that is better than the worst tet now. Edges on the boundary are swapped within a smooth
/// patch; feature edges never.
Verdict swap_edge(Worker& w, TetId t, VertexId a, VertexId b);

/// Replaces claimed tet `t` and its neighbour across `face` by three tets around the edge between their
/// apexes, if the worst gets better.
Verdict swap_face(Worker& w, TetId t, int face);

inline constexpr int kMaxRing = 9;

}  // namespace weft::meshing

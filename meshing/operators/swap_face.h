// Face swap: two tets that share a face are replaced by three.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// Replaces claimed tet `t` and its neighbour across `face` by three tets around the edge between their
/// apexes, if the worst gets better.
Verdict swap_face(Worker& w, TetId t, int face);

}  // namespace weft::meshing

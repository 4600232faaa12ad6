// What an operator must leave behind, looked at after each commit where assertions are normal or heavy.
#pragma once

#include "meshing/base/assert.h"
#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// Throws AssertionFailed unless every tet of the ball of `v`, which the worker holds, is exactly positive,
/// has live vertices, and has neighbours that know it by the same three vertices and the same patch.
void check_ball(Worker& w, VertexId v);

inline void check_cavity(Worker& w, VertexId v) {
  if constexpr (asserts(kAssertNormal)) check_ball(w, v);
}

}  // namespace weft::meshing

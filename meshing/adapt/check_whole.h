// The whole mesh looked at between passes, where assertions are heavy.
#pragma once

#include "meshing/base/assert.h"
#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// Throws AssertionFailed with the first problem that check_mesh finds. `when`: for the message.
void check_live_mesh(const TetMesh& mesh, const char* when);

inline void check_whole(const TetMesh& mesh, const char* when) {
  if constexpr (asserts(kAssertHeavy)) check_live_mesh(mesh, when);
}

}  // namespace weft::meshing

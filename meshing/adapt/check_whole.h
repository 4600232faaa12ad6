// The whole mesh looked at between passes, where assertions are heavy.
#pragma once

#include "meshing/base/assert.h"
#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// Throws AssertionFailed with the first problem that check_mesh finds. `when`: for the message.
void check_live_mesh(const TetMesh& mesh, const char* when);

/// Whether live tets have live vertices and neighbours that know them, and live vertices a tet of theirs: so
/// it is after every operation. Takes no memory.
bool links_hold(const TetMesh& mesh);

inline void check_whole(const TetMesh& mesh, const char* when) {
  if constexpr (asserts(kAssertHeavy)) check_live_mesh(mesh, when);
}

}  // namespace weft::meshing

// The tets at chosen vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/kernel/tet_mesh.h"

namespace weft::partition {

/// Calls f(tet, its vertices) for each live tet with a vertex v of which at[v], by slot, is not 0; in
/// ascending order. One look at all tets: most have none, and are left after four loads without a branch
/// between.
template <class T, class F>
void for_each_tet_at(const meshing::TetMesh& mesh, const std::vector<T>& at, F f) {
  const std::uint32_t slots = mesh.tet_slots();
  for (std::uint32_t i = 0; i < slots; ++i) {
    const meshing::TetId t(i);
    const meshing::TetVertices v = mesh.vertices(t);
    if ((at[v[0].value] | at[v[1].value] | at[v[2].value] | at[v[3].value]) == 0 || !mesh.alive(t)) continue;
    f(t, v);
  }
}

}  // namespace weft::partition

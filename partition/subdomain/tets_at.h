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
  const auto at_corner = [&](meshing::TetId t, int i) { return at[mesh.vertex(t, i).value]; };
  for (std::uint32_t i = 0; i < slots; ++i) {
    const meshing::TetId t(i);
    if ((at_corner(t, 0) | at_corner(t, 1) | at_corner(t, 2) | at_corner(t, 3)) == 0 || !mesh.alive(t))
      continue;
    f(t, mesh.vertices(t));
  }
}

}  // namespace weft::partition

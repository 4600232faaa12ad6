// Carries fields to another mesh, linearly or keeping their integrals, and says what was lost on the way.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "weft/data.h"

namespace weft::meshing {

/// `fields` at the vertices of `from`, at those of `to`. Multithreaded on TBB; does not depend on the number
/// of threads. Both ways keep positive definite tensors definite; others go component by component. Cost:
/// linear 2 us a vertex; conservative 20 to 40 us a tet of the finer mesh, and 300 bytes a vertex of `to`.
/// Throws InputError naming the tet (1-based) of `from` without volume, and for a `to` with such a tet or
/// without any.
Transfer transfer(const MeshData& from, const SolutionData& fields, const MeshData& to,
                  TransferMethod method);

}  // namespace weft::meshing

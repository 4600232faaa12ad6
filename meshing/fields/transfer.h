// Carries fields to another mesh, linearly or keeping their integrals, and says what was lost on the way.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/fields/mesh_pair.h"
#include "meshing/mesh/mesh_data.h"
#include "weft/data.h"

namespace weft::meshing {

/// `fields` at the vertices of `from`, at those of `to`. Multithreaded on TBB; does not depend on the number
/// of threads. Both ways keep positive definite tensors definite; others go component by component. Cost:
/// linear 2 us a vertex; conservative 20 to 40 us a tet of the finer mesh, and 300 bytes a vertex of `to`.
/// `interrupt`: once set, overlaps are looked for no more, and what is carried conservatively is so linearly.
/// Throws InputError naming the tet (1-based) without volume, or for a mesh without any; NewMeshError where
/// that is `to`.
Transfer transfer(const MeshData& from, const SolutionData& fields, const MeshData& to, TransferMethod method,
                  const std::atomic<bool>* interrupt = nullptr);
/// The same for a pair of meshes, perhaps in parts: `fields` at the vertices of the part of the old mesh, of
/// the same kinds and names everywhere, at those of the part of the new one; the accounts are the whole
/// meshes'. Whose flag is set interrupts all.
Transfer transfer(MeshPair& meshes, const SolutionData& fields, TransferMethod method);

/// What transfer() would be to the same mesh without rounding: fields that stay, and their account.
Transfer keep_fields(const MetricDomain& mesh, const SolutionData& fields, TransferMethod method);

}  // namespace weft::meshing

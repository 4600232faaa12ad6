// Carries fields from a mesh in slices to another one, on all ranks together.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "meshing/fields/transfer.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// All ranks: `fields` at the points of the slices of `from`, of the same kinds and names everywhere, at
/// those of the slices of `to`; the accounts, the same on all ranks, are the whole meshes'. No rank sees more
/// than its parts and what is near them. `interrupt`: as of meshing::transfer(), of any rank.
/// `slices_are_read`: called before what takes most memory; nothing of `from`, `to` and `fields` is read
/// after it but the kinds and names of the fields. Throws InputError, the same on all ranks,
/// meshing::NewMeshError for a fault of `to`.
meshing::Transfer transfer_in_parts(Peers& peers, const MeshSlice& from, const meshing::SolutionData& fields,
                                    const MeshSlice& to, meshing::TransferMethod method,
                                    const std::atomic<bool>* interrupt = nullptr,
                                    const std::function<void()>& slices_are_read = {});

/// All ranks: meshing::keep_fields() of fields at the points of these slices, at the points of other slices
/// of the same mesh, of which this rank has `points`.
meshing::Transfer keep_fields_in_parts(Peers& peers, const MeshSlice& slice,
                                       const meshing::SolutionData& fields, std::uint64_t points,
                                       meshing::TransferMethod method);

}  // namespace weft::partition

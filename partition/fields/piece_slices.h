// The pieces of a result as slices of the whole mesh.
#pragma once

#include <span>

#include "partition/communication/peers.h"
#include "partition/output/numbering.h"
#include "partition/output/piece_fields.h"
#include "partition/slice/mesh_slice.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// All ranks: points and tets in the order of the whole mesh (number_pieces), in equal shares by rank; no
/// references, metrics and boundary. Throws meshing::InputError, alike, for more points than slices can
/// number.
MeshSlice slice_of_pieces(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering);

/// All ranks: fields at the points of the slices, at all points of each piece.
PieceFields fields_of_pieces(Peers& peers, const MeshSlice& slice, const Numbering& numbering,
                             const meshing::SolutionData& of_slice);

}  // namespace weft::partition

// The check that every result in pieces passes before anybody gets it.
#pragma once

#include <span>

#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// All ranks: whether the pieces together conform, by meshing::sum_faces() with global ids: one reduction of
/// three numbers.
bool conforms(Peers& peers, std::span<const MeshPiece> mine);
/// All ranks: throws InvariantViolation, on all ranks, that names what check_pieces() finds, where they do
/// not.
void check_result(Peers& peers, std::span<const MeshPiece> mine);

}  // namespace weft::partition

// The pieces of a result as slices of the whole mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/distribute/mesh_slice.h"
#include "partition/output/numbering.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// All ranks: points and tets in the order of the whole mesh (number_pieces), in equal shares by rank; no
/// references, metrics and boundary.
MeshSlice slice_of_pieces(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering);

/// All ranks: values at the points of the slices, at all points of each piece.
std::vector<std::vector<double>> at_pieces(Peers& peers, const MeshSlice& slice, const Numbering& numbering,
                                           const std::vector<double>& of_slice, std::size_t columns);

}  // namespace weft::partition

// The boundary of an input as that of the result.
#pragma once

#include <cstdint>
#include <span>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// All ranks: gives a piece made of the slice (piece_of_slice(), with the ends of the slice's edges, the
/// places of its points among `numbers`) the boundary as it is listed: to tets their triangles, in the order
/// of their first tets over all ranks, and edges and corners in the order of the input. Returns false, on all
/// ranks, where adaptation would leave out a listed triangle or edge, require an edge at which the mesh
/// touches itself, or drop a point: the piece is of no use then. Whether triangles are missing is left to
/// conforms().
bool take_given_boundary(Peers& peers, const MeshSlice& slice, std::span<const std::uint32_t> numbers,
                         MeshPiece& piece);

}  // namespace weft::partition

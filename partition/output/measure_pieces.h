// Measures of a result that lies in pieces, without gathering it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/metric/measures.h"
#include "partition/communication/peers.h"
#include "partition/output/numbering.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// One array of flags a piece, one flag a vertex.
using VertexFlags = std::vector<std::vector<std::uint8_t>>;

/// All ranks: what meshing::measure says of merge_pieces() of all pieces: counts and qualities exactly, sums
/// and lengths but for rounding (another order, the other end). Does not depend on which rank has which
/// pieces, nor on the number of threads (TBB, in the caller's arena).
meshing::Measures measure_pieces(Peers& peers, std::span<const MeshPiece> mine);

struct WholeAndPart {
  meshing::Measures whole, part;
};

/// Likewise, and of a part of the mesh beside it: the tets with a flagged vertex, their vertices and edges,
/// and the triangles with a flagged vertex. Copies of a vertex have the same flag; flags[p] is for mine[p].
/// `numbering`: what number_pieces() says of these pieces, where it has been asked; on all ranks or none.
WholeAndPart measure_pieces(Peers& peers, std::span<const MeshPiece> mine, const VertexFlags& flags,
                            const Numbering* numbering = nullptr);

}  // namespace weft::partition

// Numbers in the whole mesh for what the pieces have, without the whole mesh anywhere.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/io/gmf/gmf_format.h"
#include "partition/communication/peers.h"
#include "partition/output/piece_share.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// Where one piece's own entities (PieceShare) go in the whole mesh: they follow those of the lower
/// subdomains, in the piece's order.
struct PieceNumbers {
  PieceShare share;
  meshing::gmf::MeshCounts first;     ///< number of the first one of each kind
  std::vector<std::uint64_t> points;  ///< 0-based number of every vertex, also of those that others own
};

struct Numbering {
  meshing::gmf::MeshCounts totals;   ///< of the whole mesh
  std::vector<PieceNumbers> pieces;  ///< in the order of the pieces given
};

/// All ranks: numbers the entities of all pieces by subdomain, then by the piece's order; the result does not
/// depend on which rank has which pieces. Throws meshing::InputError, the same on all ranks, for two pieces
/// of one subdomain, arrays that do not fit each other, and a vertex that the lowest of its holders does not
/// have.
Numbering number_pieces(Peers& peers, std::span<const MeshPiece> mine);

}  // namespace weft::partition

// Writes the result as one file a piece, for viewers and for programs that are distributed themselves.
#pragma once

#include <filesystem>
#include <span>

#include "partition/communication/peers.h"
#include "partition/output/piece_fields.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

// In both functions every rank writes the pieces that it has. When any rank fails all throw the same
// meshing::InputError, and the files of this call are removed.

/// All ranks: NAME_0.vtu, NAME_1.vtu, ... by subdomain, and then on rank 0 their index NAME.pvtu. Points
/// carry the numbers of number_pieces as global ids, the metric and the fields; cells `subdomain` and (tets;
/// else NaN) `quality`, the mean ratio in the metric. Triangles, edges and corners of several pieces are in
/// one of them.
void write_pieces_as_vtu(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& index,
                         const PieceFields& fields = {});

/// All ranks: for NAME.meshb (or NAME.mesh) NAME.0.meshb, NAME.1.meshb, ... by subdomain, with the vertices
/// that a piece shares with each other one as ParMmg's parallel communicators, whose ranks are the
/// subdomains; and beside them the metrics, NAME.0.solb (NAME.0.sol).
void write_pieces_for_parmmg(Peers& peers, std::span<const MeshPiece> mine,
                             const std::filesystem::path& mesh);

}  // namespace weft::partition

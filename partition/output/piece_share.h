// Which piece speaks for an entity that several pieces have.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// Flags of one entry an entity of a piece (corners and required_points: of the piece's list): 1 where the
/// piece has the entity and no piece of a lower subdomain has it too, or as MeshPiece::own_points says. Over
/// all pieces every entity of the whole mesh has exactly one. Tets need no flags; ridges, required edges and
/// triangles go with the edges and triangles.
struct PieceShare {
  std::vector<std::uint8_t> points;
  std::vector<std::uint8_t> triangles;
  std::vector<std::uint8_t> edges;
  std::vector<std::uint8_t> corners;
  std::vector<std::uint8_t> required_points;
  std::vector<std::uint8_t> on_nodes, on_edges, on_faces;  ///< of the records of meshing::Association
  /// Of the vertices: 1 where the piece has a record of the vertex's own kind of entity (a node before an
  /// edge, an edge before a face) and no lower one has such a record of it. Who has only other tets at a
  /// vertex may know less of it, or nothing.
  std::vector<std::uint8_t> on_model;
};

/// All ranks: the shares of the pieces here, in their order. No two pieces on any rank have the same
/// subdomain.
std::vector<PieceShare> shares_of(Peers& peers, std::span<const MeshPiece> mine);

/// 1 for the vertices of a piece that others have too.
std::vector<std::uint8_t> shared_flags(const MeshPiece& piece);

}  // namespace weft::partition

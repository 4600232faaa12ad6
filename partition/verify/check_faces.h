// Faces of the tets of one piece: what can be checked within it, and what others must say.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/problems.h"
#include "partition/communication/home_rank.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// A face that has one tet in its piece; the other may be in another piece. Plain data without padding.
struct OpenFace {
  EntityKey<3> key;
  std::uint64_t subdomain;  ///< SubdomainId::value
  std::uint64_t tet;        ///< 0-based, in the piece
  std::int32_t tet_ref;
  std::int32_t side;  ///< 1 or -1: where the tet is, seen from the vertices in the order of the key
  std::int32_t triangle_ref;
  std::int32_t has_triangle;
};

/// Checks orientations, pairs of tets and triangles within a piece with valid arrays; returns the faces that
/// are open in it.
std::vector<OpenFace> check_faces(const MeshPiece& piece, meshing::Problems& problems);

/// Checks the copies of one face, from all pieces that have it open.
void check_open_face(const OpenFace* begin, const OpenFace* end, meshing::Problems& problems);

}  // namespace weft::partition

// One mesh of several files or zones that each hold a part.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// A part of a mesh: its points may have numbers that are the same in all parts.
struct MeshPiece {
  MeshContents contents;
  std::vector<std::int64_t> global_ids;  ///< of the points, or none
};

/// What there is in a piece.
struct PieceSize : MeshSize {
  bool has_ids = false;       ///< of its points
  std::uint8_t not_refs = 0;  ///< bits of the names whose values are no references here
};

/// What one of several readers takes of a piece: the points and tets of a range, and `others`: all triangles,
/// edges and corners, and the account of what has no place here.
struct PieceRange {
  MeshRange rows;
  bool others = true;
  std::uint8_t not_refs = 0;  ///< those of all pieces: pieces agree on what their references are
};
inline bool is_empty(const PieceRange& range) {
  return range.rows.num_points == 0 && range.rows.num_tets == 0 && !range.others;
}

/// That of every piece: vertices are numbered as in the piece, of which there are no fields.
struct PieceRanges {
  std::vector<MeshPiece> pieces;
  RefNames names;
};

/// Puts pieces together: points with the same global ID, or without IDs at the same place, become one. IDs
/// that are 0, 1, 2, ... give the order of the points. Names are not merged.
MeshContents merge_pieces(std::vector<MeshPiece> pieces);

}  // namespace weft::meshing

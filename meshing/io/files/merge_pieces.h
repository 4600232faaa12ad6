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

/// Puts pieces together: points with the same global ID, or without IDs at the same place, become one. IDs
/// that are 0, 1, 2, ... give the order of the points. Names are not merged.
MeshContents merge_pieces(std::vector<MeshPiece> pieces);

}  // namespace weft::meshing

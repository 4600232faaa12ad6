// Fields of a result in pieces.
#pragma once

#include <filesystem>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::partition {

/// Fields that were carried to the result.
struct PieceFields {
  std::filesystem::path file;                    ///< of their own, beside the mesh; empty: none
  meshing::SolutionData kinds;                   ///< kinds and names, no values: the same on all ranks
  std::vector<meshing::SolutionData> of_pieces;  ///< at all points of each piece
};

}  // namespace weft::partition

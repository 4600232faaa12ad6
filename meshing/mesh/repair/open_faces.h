// Faces at which a mesh that should be whole is not.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct OpenFace {
  Triangle vertices;       ///< ascending
  std::uint32_t code = 0;  ///< tet * 4 + face
  friend auto operator<=>(const OpenFace&, const OpenFace&) = default;
};

/// All faces of the tets, those with the same vertices next to each other.
std::vector<OpenFace> sorted_faces(const MeshData& mesh);
/// Those that one tet alone has and no triangle is listed for, in the same order: of a mesh that lists its
/// boundary there are none, else its boundary is among them. O(n log n).
std::vector<OpenFace> open_faces(const MeshData& mesh);

}  // namespace weft::meshing

// Whether a mesh has all that an adaptation would give it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Whether an adaptation that has nothing to do would leave this mesh as it is: it conforms (sum_faces()),
/// its boundary lacks no triangle, all points belong to tets, the listed edges are sides of triangles, each
/// listed once, and the mesh touches itself nowhere. False too where it has records of vertices on a CAD
/// model, which are of use together with that alone. Indices must be in range (check_arrays()). Multithreaded
/// on TBB.
bool is_complete(const MeshData& mesh);

/// Of sides of triangles and the edges that are listed, with lower vertices first, both in any order: whether
/// each edge is a side and listed once, and no side belongs to more than two of the outer triangles.
struct TriangleSide {
  std::array<std::uint32_t, 2> vertices;
  std::uint32_t outer;  ///< 1 where its triangle has a tet on one side only, else 0
  friend auto operator<=>(const TriangleSide&, const TriangleSide&) = default;
};
bool edges_are_complete(std::vector<TriangleSide> sides, std::vector<std::array<std::uint32_t, 2>> edges);

}  // namespace weft::meshing

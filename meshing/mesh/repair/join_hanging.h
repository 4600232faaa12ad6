// Makes meshes conform in which vertices lie on edges or faces of tets that do not have them.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct HangingJoins {
  std::map<std::uint32_t, double> vertices;  ///< that have been joined -> largest distance from edge or face
  std::vector<std::uint32_t> swapped;        ///< one tet of each pair that has been swapped
  /// Of each row that was appended: the one that it is a part of.
  std::vector<std::uint32_t> tets, triangles, edges;
};

/// Where a vertex of an open face (open_faces.h) lies on an edge of another, within a millionth of the
/// diagonal and a hundredth of the edge, and open edges lead to it along that edge, all that is at the edge
/// is split there: tets, triangles and edges, each in two. A tet is split in three where such a vertex lies
/// inside its open face. Listed triangles that are no faces are split too where their parts are faces. Where
/// the two sides of a quadrangle then have different diagonals, a pair of tets that has all of one side is
/// swapped. On and on, until nothing changes. What would turn a tet over, or make it flat, is left.
HangingJoins join_hanging_vertices(MeshData& mesh);

}  // namespace weft::meshing

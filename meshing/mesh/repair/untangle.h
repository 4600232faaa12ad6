// Tets that are inverted or flat become positive by moving their vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// `inner`: vertices inside. `boundary`: those too, and before them vertices within smooth parts of the
/// boundary, which go towards the middle of their neighbours there: as the input has it the body is folded at
/// such a vertex. `ridge`: before these, vertices with two neighbours along listed edges, or along the border
/// of triangles of different references; they go towards the middle of the two. None moves corners, nor what
/// is required.
enum class VertexGroup { inner, boundary, ridge };

struct MovedPoint {
  std::uint32_t vertex;
  Point from;
};

/// Moves vertices of tets that are not positive as long as fewer tets become so, or the worst gets better.
/// Some may be left.
std::vector<MovedPoint> untangle(MeshData& mesh, VertexGroup group);

}  // namespace weft::meshing

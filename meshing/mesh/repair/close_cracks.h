// Makes meshes conform in which vertices that should be one are a little apart.
#pragma once

#include <cstdint>
#include <map>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Vertices of open faces (open_faces.h), and which of those with smaller numbers each should become. They
/// are within a millionth of the diagonal and a hundredth of the shortest edge at either, belong to two open
/// faces that so become one face with a tet on either side, and turn no tet over.
std::map<std::uint32_t, std::uint32_t> cracks_to_close(const MeshData& mesh);

/// What is nearer to something in a mesh than this, against its diagonal, may be meant to be there: files in
/// single precision are off by 1e-7 of it.
inline constexpr double kNearlyThere = 1e-6;
/// The same against edges.
inline constexpr double kNearlyThereOfEdge = 0.01;

}  // namespace weft::meshing

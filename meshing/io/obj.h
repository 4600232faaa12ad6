// Wavefront OBJ surfaces (.obj): points, polygons, lines, in named groups.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads points, faces (polygons are cut into triangles) and lines. References are the groups (`g`, or `o`)
/// with their names; texture coordinates, normals and materials are dropped. Throws InputError.
MeshContents read_obj(const std::filesystem::path& path);

/// Writes triangles and edges with the points they use, each reference as a group, whole or not at all.
/// Coordinates come back exactly.
void write_obj(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

}  // namespace weft::meshing

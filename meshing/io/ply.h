// PLY surfaces (.ply), ASCII and binary in both byte orders.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads vertices, faces (polygons are cut into triangles) and edges. An integer property `ref` is their
/// reference; real properties of vertices are fields. Other properties are dropped. Throws InputError.
MeshContents read_ply(const std::filesystem::path& path);

/// Writes triangles and edges with the points they use, their references and the scalar fields, whole or not
/// at all. Coordinates come back exactly.
void write_ply(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

}  // namespace weft::meshing

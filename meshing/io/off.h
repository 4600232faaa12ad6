// Surfaces in Geomview's Object File Format (.off), ASCII: points and polygons, nothing else.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads points and polygons, which are cut into triangles; faces of two points are edges. What may stand
/// behind a point (colours, normals) and a face (colours) is dropped. Throws InputError.
MeshContents read_off(const std::filesystem::path& path);

/// Writes triangles with the points they use. Coordinates come back exactly; references do not, edges
/// neither.
void write_off(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

}  // namespace weft::meshing

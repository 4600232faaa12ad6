// Meshes of the flow solver SU2 (.su2): text, boundaries by name.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads one three-dimensional zone: tets and the triangles of the markers, whose names get references (a
/// number is its own). Other elements and what SU2 keeps besides are dropped. Throws InputError.
MeshContents read_su2(const std::filesystem::path& path);

/// Writes tets, points and a marker for each reference of triangles, whole or not at all; exactly.
void write_su2(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

}  // namespace weft::meshing

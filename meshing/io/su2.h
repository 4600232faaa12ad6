// Meshes of the flow solver SU2 (.su2): text, boundaries by name.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/mesh_stream.h"
#include "meshing/io/files/part_writer.h"

namespace weft::meshing {

/// Reads one three-dimensional zone: tets and the triangles of the markers, whose names get references (a
/// number is its own). Other elements and what SU2 keeps besides are dropped. Throws InputError.
MeshContents read_su2(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);
/// The same, but for points and tets, which go to the stream: the file is never in memory as a whole.
MeshContents stream_su2(const std::filesystem::path& path, MeshStream& stream);

/// Writes tets, points and a marker for each reference of triangles, whole or not at all; exactly.
void write_su2(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

// The same file by several writers. Its text is in sections: tets, points, and triangles of each reference.

/// What stands before the rows of each section.
std::vector<std::string> su2_heads(const WholeMesh& whole);
/// The rows of a part, which must outlive it.
std::unique_ptr<TextPart> open_su2_part(const WholeMesh& whole, const MeshPart& part);

}  // namespace weft::meshing

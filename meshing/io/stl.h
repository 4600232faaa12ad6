// STL surfaces (.stl), binary and ASCII: triangles as triples of points.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads triangles; equal points become one, triangles with two equal corners are dropped. References are the
/// solids of an ASCII file (with their names), the attribute words of a binary one. Throws InputError.
MeshContents read_stl(const std::filesystem::path& path);

/// Writes the triangles, whole or not at all. Binary: coordinates are rounded to 32 bits, and references that
/// do not fit 16 bits become 0. ASCII keeps coordinates exactly and makes each reference a solid.
void write_stl(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

}  // namespace weft::meshing

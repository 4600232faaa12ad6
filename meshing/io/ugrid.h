// UGRID meshes of AFLR3, FUN3D and refine (.ugrid); what stands before the extension names the encoding.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

// NAME.lb8.ugrid and NAME.b8.ugrid are binary, little- and big-endian; .lb8l and .b8l have 64-bit integers,
// .lb4 and .b4 32-bit reals. NAME.ugrid is ASCII.

/// Reads tets and triangles; the references of triangles are the surface IDs, with names where NAME.mapbc
/// lies beside the file; those of tets the volume IDs, where it has them. Other elements are dropped. Throws
/// InputError.
MeshContents read_ugrid(const std::filesystem::path& path);

/// Writes tets, triangles and their references, whole or not at all.
void write_ugrid(const std::filesystem::path& path, const MeshView& contents,
                 const WriteOptions& options = {});

}  // namespace weft::meshing

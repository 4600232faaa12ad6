// Writes Gmsh's files (.msh): MSH 4.1, also by many together, and 2.2, ASCII and binary.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/part_writer.h"

namespace weft::meshing {

/// Tets, triangles, edges, and corners as points, whole or not at all: references as physical groups (0:
/// none), MSH 4.1 or 2.2, binary or ASCII with as many digits as give the numbers back exactly. In 4.1
/// elements are ordered by reference.
void write_gmsh(const std::filesystem::path& path, const MeshView& contents,
                const WriteOptions& options = {});

/// The same file, binary, by many; see begin_parts() in mesh_file.h.
PartPlaces begin_gmsh_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                            const WholeMesh& whole);
std::unique_ptr<PartWriter> open_gmsh_part(PartTarget target, const WholeMesh& whole,
                                           const PartPlaces& places);

/// The same in ASCII; see text_heads() in mesh_file.h.
std::vector<std::string> gmsh_heads(const std::filesystem::path& name, const WholeMesh& whole);
std::unique_ptr<TextPart> open_gmsh_text_part(const WholeMesh& whole, const MeshPart& part);

}  // namespace weft::meshing

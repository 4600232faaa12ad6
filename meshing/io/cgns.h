// CGNS files (.cgns) through the CGNS library, in HDF5.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads the unstructured zones of the first base (several are joined where their points coincide): tets,
/// triangles and bars. References are given to names: of boundary conditions at faces, else of sections.
/// Solutions at vertices are fields (NAMEX, NAMEY, NAMEZ are a vector). Other elements and nodes of CGNS are
/// dropped. Throws InputError.
MeshContents read_cgns(const std::filesystem::path& path);

/// Writes one zone, whole or not at all: a section for each reference, and for triangles a boundary condition
/// of the same name; names are cut to CGNS's 32 characters.
void write_cgns(const std::filesystem::path& path, const MeshView& contents,
                const WriteOptions& options = {});

}  // namespace weft::meshing

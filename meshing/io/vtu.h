// VTK unstructured grids (.vtu), for a look at a mesh and its fields in ParaView.
#pragma once

#include <filesystem>

#include "meshing/mesh_data.h"

namespace weft::meshing {

/// Writes points and tets, the tets' references as cell data `ref`, and `fields` (may be null) as point data,
/// in binary, whole or not at all. Fields without a name are called field_1, field_2, ... Tensors are put in
/// VTK's order xx yy zz xy yz xz. Throws InputError when writing fails.
void write_vtu(const std::filesystem::path& path, const MeshData& mesh, const SolutionData* fields = nullptr);

}  // namespace weft::meshing

// Coordinates in formats with 32-bit reals.
#pragma once

#include <string>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Throws InputError for `file` naming the first vertex that is too far away for single precision, or the
/// first tet that is positive and would be flat or inverted once its vertices are rounded: what was written
/// could not be read again as a mesh.
void refuse_if_rounding_breaks(const MeshData& mesh, const std::string& file);

}  // namespace weft::meshing

// Renumbering along a space-filling curve, for locality, and without holes.
#pragma once

#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// Orders vertices along a Hilbert-like (Morton) curve through the bounding box, tets by their first vertex
/// in that order, and closes all holes. Ids change; free-slot lists kept elsewhere become invalid.
void renumber_along_curve(TetMesh& mesh);

}  // namespace weft::meshing

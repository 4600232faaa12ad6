// A structured mesh of a box, the start mesh for cases whose geometry is a box: `weft mesh box`.
#pragma once

#include <array>
#include <cstdint>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"
#include "weft/data.h"

namespace weft::meshing {

/// A box of cells of 6 tets each (Kuhn). Triangle references: 1 x-min, 2 x-max, 3 y-min, 4 y-max, 5 z-min,
/// 6 z-max; the 12 box edges are edges and ridges with references 1 to 12 (4 along x, 4 along y, 4 along z),
/// the 8 box corners are corners, tets have reference 1. With two cells or more in every direction no tet has
/// two faces on the boundary, so that no tet's four vertices are all on a pair of box faces. Throws
/// InputError for no cells, too many for 32-bit indices, or a box without volume.
MeshData structured_box(const BoxOptions& options);

}  // namespace weft::meshing

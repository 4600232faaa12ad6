// The triangles of the input surface made faces of the grid.
#pragma once

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Makes every facet a set of grid faces and marks them: flips where they do, Steiner points where the facet
/// cuts grid edges elsewhere. The input edges must be there. Throws InputError naming the triangle.
void recover_facets(Recovery& r);

}  // namespace weft::meshing

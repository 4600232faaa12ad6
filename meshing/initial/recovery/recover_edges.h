// The edges of the input surface made edges of the grid.
#pragma once

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Lists the edges of the facets.
void list_input_edges(Recovery& r);

/// Makes every input edge a chain of grid edges: flips where they do, Steiner points on the edge elsewhere.
/// Throws InputError naming the ends (1-based) where not even that is possible.
void recover_edges(Recovery& r);

}  // namespace weft::meshing

// Steiner points moved off the surface, which then is the input's.
#pragma once

#include <cstdint>

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Moves Steiner points off the surface into the tets beside it, one copy for each side, and closes the
/// facets without them: the surface is then the input's, triangle by triangle. Those that find no
/// room there stay; returns their number. Only tets that are in use may be in the grid.
std::uint64_t lift_steiner_points(Recovery& r);

/// Puts those that are left at doubles. Throws InputError naming the triangle where that would turn a tet
/// over.
void round_steiner_points(Recovery& r);

}  // namespace weft::meshing

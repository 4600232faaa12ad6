// Tets without volume to speak of, swapped away.
#pragma once

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Swaps away tets that are flat to rounding (of cospherical points in one plane): they leave Steiner points
/// no room.
void remove_slivers(Recovery& r);

}  // namespace weft::meshing

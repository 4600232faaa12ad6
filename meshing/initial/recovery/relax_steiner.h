// Steiner points moved to better places on the surface.
#pragma once

#include <cstdint>

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Moves the Steiner point v along its input edge, between two parameters, to where the worst tet of its ball
/// is best.
void relax_on_edge(Recovery& r, std::uint32_t v, double least, double most);

/// The same within a facet that is not yet marked.
void relax_on_facet(Recovery& r, std::uint32_t v);

}  // namespace weft::meshing

// One more point in the grid.
#pragma once

#include <cstdint>
#include <span>

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Connects point v to a cavity around it that starts as `seed` (the tets of the face or edge that it is on)
/// and grows beyond faces that v does not see or, if that can be, sees too flatly. False, and nothing done,
/// where a facet, an input edge or a vertex would be lost.
bool insert_steiner(Recovery& r, std::span<const std::uint32_t> seed, std::uint32_t v);

}  // namespace weft::meshing

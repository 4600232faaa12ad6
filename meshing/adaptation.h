// Adapts a mesh that is in the kernel already: what adapt() does with a whole mesh and what is done with a
// subdomain, whose interface is frozen, again and again.
#pragma once

#include "meshing/adapt.h"
#include "meshing/kernel.h"

namespace weft::meshing {

/// What of the mesh is looked at.
enum class Extent : std::uint8_t {
  everything,
  fresh,  ///< tets with the mark kFresh, and whatever changes around them
};

/// Runs the stages collapse, create points, reconnect and smooth, improve, and adds them to `report`. Nothing
/// that has a frozen vertex changes. Vertices must have their metrics; ids change (holes are closed) unless
/// the extent is `fresh` and few entities are dead.
void adapt_in_place(Kernel& kernel, const AdaptOptions& options, Extent extent, AdaptReport& report);

}  // namespace weft::meshing

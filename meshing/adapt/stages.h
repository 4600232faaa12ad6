// Adapts a mesh that is in the kernel already: what adapt() does with a whole mesh and what is done with a
// subdomain, whose interface is frozen, again and again.
#pragma once

#include <functional>

#include "meshing/adapt/adapt.h"
#include "meshing/kernel/kernel.h"
#include "meshing/metric/expectations.h"

namespace weft::meshing {

/// What of the mesh is looked at.
enum class Extent : std::uint8_t {
  everything,
  fresh,  ///< tets with the mark kFresh, and whatever changes around them
};

/// Called before points are created at a level, with the length beyond which edges are long there; the last
/// call has limits.long_edge, and comes even when the adaptation is interrupted. What it splits is taken up;
/// `mean` is the one in which its qualities are cached.
using BeforeLevel = std::function<void(double long_edge, MetricMean mean)>;

/// Runs the stages collapse, create points, reconnect and smooth, improve, and adds them to `report`. Frozen
/// vertices stay. Vertices must have their metrics; ids change (holes are closed) unless the extent is
/// `fresh` and few entities are dead.
void adapt_in_place(Kernel& kernel, const AdaptOptions& options, Extent extent, AdaptReport& report,
                    const BeforeLevel& before_level = {});

}  // namespace weft::meshing

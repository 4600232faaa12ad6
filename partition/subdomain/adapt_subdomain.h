// One adaptation of what is free in a subdomain.
#pragma once

#include <atomic>

#include "meshing/adapt/stages.h"
#include "meshing/kernel/nonconforming.h"
#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// Adapts everything that is not frozen (`everything`), or what arrived and what borders on it (`fresh`;
/// nothing is done where nothing is). Limits::hausd: not 0. `before_level` as in meshing::adapt_in_place; it
/// names its own new vertices, others have their ids afterwards.
meshing::AdaptReport adapt_subdomain(Subdomain& subdomain, const meshing::Surface& surface,
                                     const meshing::Limits& limits, meshing::Extent extent,
                                     const meshing::AdaptOptions& options,
                                     const meshing::BeforeLevel& before_level = {});

/// Remaining nonconforming entities of the subdomain's mesh; apart (`flagged`) what has a vertex that is or
/// has been one of an interface. Cheap: tets are counted, edges estimated from those of 256 to 511 vertices.
meshing::NonconformingParts count_nonconforming(const Subdomain& subdomain);

}  // namespace weft::partition

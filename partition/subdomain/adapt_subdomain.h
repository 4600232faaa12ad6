// One adaptation of what is free in a subdomain.
#pragma once

#include <atomic>

#include "meshing/adapt/stages.h"
#include "meshing/kernel/nonconforming.h"
#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// Slots to reserve address space for at first, for a subdomain of `tets` tets that is predicted to have
/// `predicted`: some times that, since holes cost slots. It grows beyond; all of a process may have to share
/// what `ulimit -v` allows.
std::size_t tet_slots_for(double predicted, std::uint64_t tets);

/// Room for `more` tets; where there is too little the arrays grow to twice what is needed. Only while nobody
/// else has the mesh.
void make_room(Subdomain& subdomain, std::uint64_t more);

/// Adapts everything that is not frozen (`everything`), or what arrived and what borders on it (`fresh`;
/// nothing is done where nothing is). `surface`: any part of the whole mesh's; the pieces are the
/// subdomain's. Limits::hausd: not 0. `before_level` as in meshing::adapt_in_place; it names its own new
/// vertices, others have their ids afterwards.
meshing::AdaptReport adapt_subdomain(Subdomain& subdomain, const meshing::Surface& surface,
                                     const meshing::Limits& limits, meshing::Extent extent,
                                     const meshing::AdaptOptions& options,
                                     const meshing::BeforeLevel& before_level = {});

/// Remaining nonconforming entities of the subdomain's mesh; apart (`flagged`) what has a vertex that is or
/// has been one of an interface. Cheap: tets are counted, edges estimated from those of 256 to 511 vertices.
meshing::NonconformingParts count_nonconforming(const Subdomain& subdomain);

}  // namespace weft::partition

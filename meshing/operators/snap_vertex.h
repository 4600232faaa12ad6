// A boundary vertex that is off the CAD model goes there.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// Moves boundary vertex `v` to the closest point of its face or edge of the model, a corner to its node.
/// Where a tet would not stay positive, or a boundary triangle would turn over, it goes part of the way.
/// Accepted: it is on the model now; not_needed: it was, or lies on no entity of the model; inverts: it is
/// off still.
Verdict snap_vertex(Worker& w, VertexId v);

/// The same for any vertex of curved boundary and whatever the reference surface is.
Verdict raise_vertex(Worker& w, VertexId v);

}  // namespace weft::meshing

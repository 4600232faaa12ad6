// Solutions that a caller has in parts become values at the slices' points.
#pragma once

#include <vector>

#include "partition/communication/peers.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks, after slice_of_parts(): all scalar fields of the solutions, which are at the part's points, at
/// the points of this rank's slice. Throws the same InputError on all ranks, naming the rank or the vertex:
/// values of the wrong number or not finite, no scalar field, another number of them than elsewhere, a vertex
/// that has another value on another rank. Ranks without points need not have the fields.
Fields solutions_of_slices(partition::Peers& peers, const Part& part, const std::vector<Fields>& solutions);

}  // namespace weft::tools

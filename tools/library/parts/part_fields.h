// Fields of a mesh in parts at the points of another one in parts, by linear interpolation.
#pragma once

#include "partition/communication/peers.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: the fields of `from` (the same kinds everywhere, also on ranks without tets) at the points of
/// `to`. A point outside all parts gets the value of the closest point of the mesh. What ranks whose parts
/// are near say is compared, so the result does not depend on how the old mesh was spread but for rounding
/// where parts meet.
Fields interpolate_parts(partition::Peers& peers, const Part& from, const Part& to);

}  // namespace weft::tools

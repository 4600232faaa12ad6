// Feature edges in shares: who is to have which, so that curves are whole.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "meshing/geometry/surface/surface_curves.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: the rank that is to form the curve of each of these features, which are this rank's. Ranks get
/// about equally many edges, in whole curves. All know the parts of curves that ranks have, and how they are
/// connected.
std::vector<std::size_t> homes_of_curves(Peers& peers, std::span<const meshing::FoundFeature> mine);

}  // namespace weft::partition

// One layer of ghosts: the tets of other ranks at a part's vertices.
#pragma once

#include <vector>

#include "partition/communication/peers.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: `holders` are the other ranks that have each of the part's points. Tets and points that others
/// send come last, in the order of the ranks.
void add_ghosts(partition::Peers& peers, const std::vector<std::vector<int>>& holders, Part& part,
                std::vector<Tensor>& log_metrics);

}  // namespace weft::tools

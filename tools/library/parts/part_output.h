// The pieces of a result become the parts that callers get back: balanced, numbered, with owners and ghosts.
#pragma once

#include <vector>

#include "graph/dataflow/rank_exchange.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"
#include "weft/weft.h"

namespace weft::tools {

/// A part and the metric at its points.
struct PartWithMetric {
  Part part;
  Metric metric;
};

/// All ranks: subdomains go to the ranks in their order, so that all have about equally many tets; the pieces
/// of a rank become one mesh. With `ghosts` the tets of other ranks at its vertices come last.
PartWithMetric part_of_pieces(partition::Peers& peers, graph::dataflow::RankExchange& exchange,
                              std::vector<partition::MeshPiece> pieces, bool ghosts);

}  // namespace weft::tools

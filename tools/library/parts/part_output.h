// The pieces of a result become the parts that callers get back: balanced, numbered, with owners and ghosts.
#pragma once

#include <vector>

#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"
#include "weft/weft.h"

namespace weft::tools {

/// A part and the metric at its points.
struct PartWithMetric {
  Part part;
  Metric metric;
};

/// All ranks: the tets, in their order in the whole mesh (number_pieces), go to the ranks in equal shares,
/// with their points and with the triangles and edges that they have. With `ghosts` the tets of other ranks
/// at a part's points come last.
PartWithMetric part_of_pieces(partition::Peers& peers, const std::vector<partition::MeshPiece>& pieces,
                              bool ghosts);

}  // namespace weft::tools

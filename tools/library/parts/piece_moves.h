// All pieces of a result on rank 0: for what only one rank can do.
#pragma once

#include <vector>

#include "graph/dataflow/rank_exchange.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::tools {

/// All ranks: the pieces of all of them on rank 0, by subdomain; none elsewhere.
std::vector<partition::MeshPiece> gather_pieces(graph::dataflow::RankExchange& exchange,
                                                std::vector<partition::MeshPiece> mine);

}  // namespace weft::tools

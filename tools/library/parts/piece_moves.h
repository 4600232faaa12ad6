// Pieces of a result on their way to other ranks.
#pragma once

#include <functional>
#include <vector>

#include "graph/dataflow/rank_exchange.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::tools {

/// All ranks: every piece goes to rank to(piece); returns those that have come here, by subdomain.
std::vector<partition::MeshPiece> move_pieces(graph::dataflow::RankExchange& exchange,
                                              std::vector<partition::MeshPiece> mine,
                                              const std::function<int(const partition::MeshPiece&)>& to);

/// All ranks: the pieces of all of them on rank 0, by subdomain; none elsewhere.
std::vector<partition::MeshPiece> gather_pieces(graph::dataflow::RankExchange& exchange,
                                                std::vector<partition::MeshPiece> mine);

}  // namespace weft::tools

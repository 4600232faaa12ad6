// The graph partitioner: METIS on the dual graph of the tets.
#pragma once

#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/decompose/weighted_items.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// Bisects the items until every part has at most `most_in_graph`; METIS then divides each part's dual graph
/// into its share of the subdomains, so that interfaces have few vertices. The graphs are dealt out to the
/// ranks: about 300 bytes a tet there while it lasts. Where there are fewer than 8 items a subdomain
/// bisection alone decides. All ranks throw meshing::InputError when METIS fails on one.
std::vector<SubdomainId> graph_partition(Peers& peers, const WeightedItems& items, const ItemFaces& faces,
                                         std::uint32_t num_subdomains, std::uint64_t most_in_graph = 500'000);

}  // namespace weft::partition

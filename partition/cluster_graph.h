// The graph partitioner: METIS on clusters of tets.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "partition/global_id.h"
#include "partition/peers.h"
#include "partition/weighted_items.h"

namespace weft::partition {

/// Cuts the items into about 64 clusters of equal weight a subdomain along a Morton curve, joins clusters by
/// the number of faces they share, and lets METIS divide this graph on rank 0 (80 bytes a cluster there).
/// tets[i] has the vertices of item i, numbered alike on all ranks. Where there are fewer than 8 items
/// a subdomain the curve alone decides. Throws std::runtime_error when METIS fails.
std::vector<SubdomainId> graph_partition(Peers& peers, const WeightedItems& items,
                                         std::span<const std::array<std::uint32_t, 4>> tets,
                                         std::uint32_t num_subdomains);

}  // namespace weft::partition

// The graph partitioner: METIS on the dual graph of the tets.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/decompose/weighted_items.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

inline constexpr std::uint64_t kMostInGraph = 500'000;

/// METIS divides the dual graph of the items into subdomains, so that interfaces have few vertices. More than
/// `most_in_graph` items are bisected into groups of no more, each a graph of its own with its share of the
/// subdomains. Where there are more than twice as many, groups are smaller, down to a fifth of
/// `most_in_graph` from ten times as many on, as long as 10 subdomains are left to each, and down to 10,000
/// as long as 70 are: so many ranks have something to divide. Graphs are dealt out to the ranks: about 300
/// bytes a tet there while it lasts, before which `items_are_read` is called: nothing of `items` and `faces`
/// is read any more. Where there are fewer than 8 items a subdomain bisection alone decides. All ranks call
/// together, and throw meshing::InputError when METIS fails on one. The result depends neither on their
/// number nor on who has what.
std::vector<SubdomainId> graph_partition(Peers& peers, const WeightedItems& items, const ItemFaces& faces,
                                         std::uint32_t num_subdomains,
                                         std::uint64_t most_in_graph = kMostInGraph,
                                         const std::function<void()>& items_are_read = {});

}  // namespace weft::partition

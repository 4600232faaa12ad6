// Connected sets of a graph that no rank has whole.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: the number of connected sets among as many nodes as all ranks own together, numbered through
/// the ranks (`mine` on this one). `edges`: pairs of any nodes; each is known to one rank at least. Hooking
/// and pointer jumping (Shiloach and Vishkin 1982): some log of the nodes rounds, each of a few exchanges; 60
/// bytes an edge.
std::uint64_t count_connected_sets(Peers& peers, std::uint64_t mine,
                                   std::vector<std::array<std::uint64_t, 2>> edges);

}  // namespace weft::partition

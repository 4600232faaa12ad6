// Shares of points that lie together: along a Morton curve.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: the box of all ranks' boxes.
meshing::Box common_box(Peers& peers, const meshing::Box& mine);

/// The place of each point along a Morton curve through the box.
std::vector<std::uint64_t> morton_keys(std::span<const meshing::Point> points, const meshing::Box& box);

/// All ranks: the first key of every rank but the first: ranks get about equally many of all keys, judged by
/// samples. None where there are no keys.
std::vector<std::uint64_t> first_keys(Peers& peers, std::vector<std::uint64_t> keys);

}  // namespace weft::partition

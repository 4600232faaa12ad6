// Boxes and principal axes of groups of weighted points that are spread over the ranks.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/box.h"
#include "meshing/point.h"
#include "partition/peers.h"
#include "partition/weighted_items.h"

namespace weft::partition {

/// Three unit vectors, right angles between them.
using Axes = std::array<meshing::Vec, 3>;

/// The box of each group's points (empty groups: as a default Box). groups[i] < num_groups is that of item i.
std::vector<meshing::Box> group_boxes(Peers& peers, std::span<const meshing::Point> points,
                                      std::span<const std::uint32_t> groups, std::uint32_t num_groups);

/// The principal axes of each group's weights: along the first they are spread widest. The same bits for any
/// number of ranks.
std::vector<Axes> principal_axes(Peers& peers, const WeightedItems& items,
                                 std::span<const std::uint32_t> groups, std::uint32_t num_groups);

}  // namespace weft::partition

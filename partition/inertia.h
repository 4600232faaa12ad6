// Boxes and principal axes of groups of weighted points that are spread over the ranks.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/box.h"
#include "meshing/metric.h"
#include "meshing/point.h"
#include "partition/peers.h"
#include "partition/weighted_items.h"

namespace weft::partition {

/// Three unit vectors, right angles between them.
using Axes = std::array<meshing::Vec, 3>;

/// The box of each group's points (empty groups: as a default Box). groups[i] < num_groups is that of item i.
std::vector<meshing::Box> group_boxes(Peers& peers, std::span<const meshing::Point> points,
                                      std::span<const std::uint32_t> groups, std::uint32_t num_groups);

/// Covariance of the coordinates of each group's weights, in units of the group's box; zero for an empty
/// group. The same bits for any number of ranks.
std::vector<meshing::SymTensor> covariances(Peers& peers, const WeightedItems& items,
                                            std::span<const std::uint32_t> groups, std::uint32_t num_groups);

/// The principal axes: along the first the weights are spread widest. The largest component of each is
/// positive.
Axes principal_axes(const meshing::SymTensor& covariance);

/// The axis to cut across: x, y or z where the weights are spread nearly as widely along it as along the
/// first principal axis (which is anything in a cube), else that.
meshing::Vec cutting_axis(const meshing::SymTensor& covariance);

}  // namespace weft::partition

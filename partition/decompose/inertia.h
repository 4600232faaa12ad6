// Boxes and principal axes of groups of weighted points that are spread over the ranks.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/point.h"
#include "meshing/metric/metric.h"
#include "partition/communication/peers.h"
#include "partition/decompose/weighted_items.h"

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

/// The axis to cut across, so that the cut has few vertices: the n of greatest n.C.n / n.T.n. The first is
/// the square of the width along n, over which the cuts with this normal are spread; the second bounds the
/// square of their mean area (Cauchy's inequality). x, y or z where that is nearly as good: in a cube all
/// axes are, and skew cuts have longer edges where they meet.
meshing::Vec cutting_axis(const meshing::SymTensor& covariance, const meshing::SymTensor& cut_tensor);

/// That of each group, by the mean of its items' cut_tensors, weighted; three reductions. The same for any
/// number of ranks.
std::vector<meshing::Vec> cutting_axes(Peers& peers, const WeightedItems& items,
                                       std::span<const std::uint32_t> groups, std::uint32_t num_groups);

}  // namespace weft::partition

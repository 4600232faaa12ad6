// Shares of points that lie together: along a Morton curve.
#pragma once

#include <cstdint>
#include <initializer_list>
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

/// Where the shares of ranks begin along a Morton curve.
struct MortonShares {
  meshing::Box box;                   ///< of all points
  std::vector<std::uint64_t> firsts;  ///< as first_keys() gives

  /// The rank of each point.
  std::vector<std::uint32_t> owners(std::span<const meshing::Point> points) const;
};

/// All ranks: shares of about equally many of the points of all meshes together. Points that are not finite
/// count for none.
MortonShares morton_shares(Peers& peers, std::initializer_list<std::span<const meshing::Point>> meshes);

}  // namespace weft::partition

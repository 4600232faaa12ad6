// Points of the whole mesh by their numbers, on a rank that does not have them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/base/point.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// The points that elements use, fetched from the ranks in whose slices they are.
class FetchedPoints {
 public:
  /// All ranks; `points`: those of the slices.
  template <std::size_t N>
  FetchedPoints(Peers& peers, const MeshSlice& slice, const Ranges& points,
                const std::vector<std::array<std::uint32_t, N>>& elements) {
    for (const auto& element : elements) numbers_.insert(numbers_.end(), element.begin(), element.end());
    meshing::sort_unique(numbers_);
    points_ = fetch<meshing::Point>(peers, points, numbers_, [&](std::size_t i) { return slice.points[i]; });
  }

  /// The corners of one of the elements.
  template <std::size_t N>
  std::array<meshing::Point, N> of(const std::array<std::uint32_t, N>& element) const {
    std::array<meshing::Point, N> corners;
    for (std::size_t i = 0; i < N; ++i) corners[i] = points_[meshing::place_in(numbers_, element[i])];
    return corners;
  }

 private:
  std::vector<std::uint32_t> numbers_;  ///< ascending
  std::vector<meshing::Point> points_;
};

}  // namespace weft::partition

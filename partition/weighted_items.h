// What the partitioners work on: tets as points with integer weights.
#pragma once

#include <cstdint>
#include <span>

#include "meshing/point.h"

namespace weft::partition {

/// This rank's tets, one entry each in every array.
struct WeightedItems {
  std::span<const meshing::Point> centres;
  std::span<const std::uint64_t> weights;  ///< at least 1; all ranks' together below 2^62
  std::span<const std::uint64_t> numbers;  ///< different for each item of all ranks
};

}  // namespace weft::partition

// What the partitioners work on: tets as points with integer weights.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "meshing/base/point.h"
#include "meshing/metric/metric.h"
#include "partition/decompose/tet_measures.h"

namespace weft::partition {

/// This rank's tets, one entry each in every array.
struct WeightedItems {
  std::span<const meshing::Point> centres;
  std::span<const TetCorners> corners;
  std::span<const std::uint64_t> weights;           ///< at least 1; all ranks' together below 2^62
  std::span<const std::uint64_t> numbers;           ///< different for each item of all ranks
  std::span<const meshing::SymTensor> cut_tensors;  ///< cut_tensor of each; not read by PQR
  std::span<const double> coordinates = {};         ///< of each, what PQR cuts first along; empty: an axis
};

/// Where they meet each other.
struct ItemFaces {
  std::span<const std::array<std::uint32_t, 4>> vertices;  ///< numbered alike on all ranks
  std::span<const std::array<float, 4>> areas;             ///< in the metric; face i is opposite vertex i
};

}  // namespace weft::partition

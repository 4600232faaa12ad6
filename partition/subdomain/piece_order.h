// The order in which a mesh is cut into pieces of background.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/point.h"

namespace weft::partition {

/// The tets of a mesh (indices into `tets`) in an order in which each run of kTetsOfPiece
/// (background_store.h) from the first one on is compact: few vertices, and few other runs beside it. Depends
/// on the arguments alone.
std::vector<std::uint32_t> piece_order(std::span<const meshing::Point> points,
                                       std::span<const std::array<std::uint32_t, 4>> tets);

}  // namespace weft::partition

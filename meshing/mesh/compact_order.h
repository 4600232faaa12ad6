// An order of tets in which runs of them are compact.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/point.h"

namespace weft::meshing {

/// The tets of a mesh (indices into `tets`) in an order in which each run of `run` tets, from the first one
/// on, is compact: few vertices, and few other runs beside it. So are runs of runs. Depends on the arguments
/// alone.
std::vector<std::uint32_t> compact_order(std::span<const Point> points,
                                         std::span<const std::array<std::uint32_t, 4>> tets, std::size_t run);
/// The same of what these boxes are about.
std::vector<std::uint32_t> compact_order(std::span<const Box> boxes, std::size_t run);

}  // namespace weft::meshing

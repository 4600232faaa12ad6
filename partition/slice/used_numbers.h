// The points that tets of a slice use.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::partition {

/// The numbers of all corners, ascending, each once. Takes no more memory than the corners beside the result.
std::vector<std::uint32_t> used_numbers(std::span<const meshing::Tet> tets);

}  // namespace weft::partition

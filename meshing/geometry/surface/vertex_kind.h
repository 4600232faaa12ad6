// How a vertex lies on the boundary.
#pragma once

#include <cstdint>

namespace weft::meshing {

/// Where on the boundary a vertex may go: nowhere (corner), along a curve, on a patch, anywhere.
enum class VertexKind : std::uint8_t { interior = 0, surface = 1, ridge = 2, corner = 3 };

}  // namespace weft::meshing

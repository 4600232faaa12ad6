// Element types of MSH files.
#pragma once

#include <cstdint>

namespace weft::meshing::gmsh {

inline constexpr std::int32_t kLine = 1, kTriangle = 2, kTetrahedron = 4, kPoint = 15;

}  // namespace weft::meshing::gmsh

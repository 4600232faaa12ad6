// Numbers of VTK.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace weft::meshing::vtk {

/// Types of cells.
enum Cell : std::uint8_t { kVertex = 1, kLine = 3, kTriangle = 5, kTetra = 10 };

/// Position in a GMF tensor (xx xy yy xz yz zz) of each component of a VTK tensor (xx yy zz xy yz xz).
inline constexpr std::array<std::size_t, 6> kTensorOrder = {0, 2, 5, 1, 4, 3};

}  // namespace weft::meshing::vtk

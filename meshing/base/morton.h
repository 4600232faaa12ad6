// Bits of a Morton code: near in space, near in the order.
#pragma once

#include <cstdint>

namespace weft::meshing {

/// Spreads the low 21 bits of x to every third bit.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace weft::meshing

// Morton codes: near in space, near in the order.
#pragma once

#include <algorithm>
#include <cstdint>

#include "meshing/base/box.h"

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

/// The places of points along a Morton curve through a cube that begins where the box does.
class MortonCurve {
 public:
  explicit MortonCurve(const Box& box)
      : lo_(box.lo), side_(std::max({box.size().x, box.size().y, box.size().z})) {}
  std::uint64_t key(const Point& p) const {
    constexpr double kCells = 1u << 21;
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i) {
      const double cell = side_ > 0 ? (p[i] - lo_[i]) / side_ * kCells : 0;
      key |= spread_bits(static_cast<std::uint64_t>(std::clamp(cell, 0.0, kCells - 1))) << i;
    }
    return key;
  }

 private:
  Point lo_;
  double side_;
};

}  // namespace weft::meshing

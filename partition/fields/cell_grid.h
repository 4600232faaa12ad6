// A grid of equal cells over a box: a coarse common language for who is near whom.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "meshing/base/box.h"

namespace weft::partition {

class CellGrid {
 public:
  /// About `cells` cells, at most 64 along an axis.
  CellGrid(const meshing::Box& box, double cells) : low_(box.lo) {
    const meshing::Vec size = box.size();
    const double largest = std::max({size.x, size.y, size.z});
    double volume = 1;
    for (int axis = 0; axis < 3; ++axis) volume *= std::max(size[axis], 1e-3 * largest);
    const double side = std::cbrt(volume / std::max(1.0, cells));
    for (int axis = 0; axis < 3; ++axis) {
      const double wanted = side > 0 ? std::ceil(size[axis] / side) : 1;
      counts_[axis] = static_cast<std::uint32_t>(std::clamp(wanted, 1.0, 64.0));
      sides_[axis] = size[axis] / counts_[axis];
    }
  }

  std::uint32_t size() const { return counts_[0] * counts_[1] * counts_[2]; }
  /// Calls visit(cell) for the cells that a box touches.
  template <class Visit>
  void for_each_cell(const meshing::Box& box, const Visit& visit) const {
    std::array<std::uint32_t, 3> first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = index(box.lo[axis], axis);
      last[axis] = index(box.hi[axis], axis);
    }
    for (std::uint32_t z = first[2]; z <= last[2]; ++z)
      for (std::uint32_t y = first[1]; y <= last[1]; ++y)
        for (std::uint32_t x = first[0]; x <= last[0]; ++x) visit((z * counts_[1] + y) * counts_[0] + x);
  }

 private:
  std::uint32_t index(double coordinate, int axis) const {
    if (!(sides_[axis] > 0)) return 0;
    const double cell = std::floor((coordinate - low_[axis]) / sides_[axis]);
    return static_cast<std::uint32_t>(std::clamp(cell, 0.0, static_cast<double>(counts_[axis] - 1)));
  }

  meshing::Point low_;
  std::array<std::uint32_t, 3> counts_{};
  std::array<double, 3> sides_{};
};

}  // namespace weft::partition

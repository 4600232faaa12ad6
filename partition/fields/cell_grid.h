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
    const auto [first, last] = touched_by(box);
    for (std::uint32_t z = first[2]; z <= last[2]; ++z)
      for (std::uint32_t y = first[1]; y <= last[1]; ++y)
        for (std::uint32_t x = first[0]; x <= last[0]; ++x) visit((z * counts_[1] + y) * counts_[0] + x);
  }

  /// The cells that any of the boxes touches, ascending. A large box takes no longer than a small one: each
  /// is added where it begins and taken off behind its end, along every axis; sums say how many are over a
  /// cell.
  template <class Boxes>
  std::vector<std::uint32_t> cells_of(const Boxes& boxes) const {
    const std::size_t nx = counts_[0] + 1, ny = counts_[1] + 1, nz = counts_[2] + 1;  // one behind the last
    std::vector<std::uint32_t> over(nx * ny * nz, 0);                                 // modulo 2^32
    for (const meshing::Box& box : boxes) {
      const auto [first, last] = touched_by(box);
      if (first[0] > last[0] || first[1] > last[1] || first[2] > last[2]) continue;  // it is empty
      for (const int z : {0, 1})
        for (const int y : {0, 1})
          for (const int x : {0, 1})
            over[((z ? last[2] + 1 : first[2]) * ny + (y ? last[1] + 1 : first[1])) * nx +
                 (x ? last[0] + 1 : first[0])] += (x + y + z) % 2 == 0 ? 1u : ~0u;
    }
    // The sum of a line of cells is 0 behind its last, so that it does not go on in the next one.
    for (const std::size_t step : {std::size_t{1}, nx, nx * ny})
      for (std::size_t i = step; i < over.size(); ++i) over[i] += over[i - step];
    std::vector<std::uint32_t> cells;
    for (std::uint32_t cell = 0; cell < size(); ++cell) {
      const std::uint32_t x = cell % counts_[0], yz = cell / counts_[0];
      if (over[(yz / counts_[1] * ny + yz % counts_[1]) * nx + x] != 0) cells.push_back(cell);
    }
    return cells;
  }

 private:
  struct Touched {
    std::array<std::uint32_t, 3> first, last;
  };
  /// Along each axis.
  Touched touched_by(const meshing::Box& box) const {
    Touched touched;
    for (int axis = 0; axis < 3; ++axis) {
      touched.first[axis] = index(box.lo[axis], axis);
      touched.last[axis] = index(box.hi[axis], axis);
    }
    return touched;
  }
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

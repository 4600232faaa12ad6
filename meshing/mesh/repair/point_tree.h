// Finds those of many points that are in a box.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/point.h"

namespace weft::meshing {

/// A kd-tree without nodes: the middle of every range of numbers divides it, along the axes in turn. It does
/// not mind that points are much denser in some places than in others.
class PointTree {
 public:
  /// Of these points, which must outlive it.
  PointTree(const std::vector<Point>& points, std::vector<std::uint32_t> numbers)
      : points_(points), numbers_(std::move(numbers)) {
    divide(0, numbers_.size(), 0);
  }

  /// Calls visit(number) for each point in the closed box, in any order.
  template <class Visit>
  void visit_in(const Box& box, const Visit& visit) const {
    visit_in(box, visit, 0, numbers_.size(), 0);
  }

 private:
  void divide(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) { return numbers_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(points_[a][axis], a) < std::pair(points_[b][axis], b);
    });
    divide(begin, middle, (axis + 1) % 3);
    divide(middle + 1, end, (axis + 1) % 3);
  }

  template <class Visit>
  void visit_in(const Box& box, const Visit& visit, std::size_t begin, std::size_t end, int axis) const {
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const Point& p = points_[numbers_[middle]];
    if (box.distance2(p) == 0) visit(numbers_[middle]);
    if (box.lo[axis] <= p[axis]) visit_in(box, visit, begin, middle, (axis + 1) % 3);
    if (box.hi[axis] >= p[axis]) visit_in(box, visit, middle + 1, end, (axis + 1) % 3);
  }

  const std::vector<Point>& points_;
  std::vector<std::uint32_t> numbers_;
};

}  // namespace weft::meshing

// Axis-aligned bounding boxes.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "meshing/base/point.h"

namespace weft::meshing {

struct Box {
  Point lo{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Point hi{-lo.x, -lo.y, -lo.z};

  void include(const Point& p) {
    for (int i = 0; i < 3; ++i) {
      lo[i] = std::min(lo[i], p[i]);
      hi[i] = std::max(hi[i], p[i]);
    }
  }
  void unite(const Box& box) {
    for (int i = 0; i < 3; ++i) {
      lo[i] = std::min(lo[i], box.lo[i]);
      hi[i] = std::max(hi[i], box.hi[i]);
    }
  }
  double distance2(const Point& p) const {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const double d = std::max({lo[i] - p[i], 0.0, p[i] - hi[i]});
      sum += d * d;
    }
    return sum;
  }
  Vec size() const { return hi - lo; }
  /// By a distance on every side.
  Box grown(double by) const { return {lo - Vec{by, by, by}, hi + Vec{by, by, by}}; }
  /// Whether they have a point in common.
  bool meets(const Box& other) const {
    for (int i = 0; i < 3; ++i)
      if (lo[i] > other.hi[i] || other.lo[i] > hi[i]) return false;
    return true;
  }
};

inline Box box_of(std::span<const Point> points) {
  Box box;
  for (const Point& p : points) box.include(p);
  return box;
}

}  // namespace weft::meshing

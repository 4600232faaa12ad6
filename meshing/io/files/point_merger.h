// Finds points that were read before by their coordinates, for formats that repeat them.
#pragma once

#include <bit>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "meshing/base/point.h"

namespace weft::meshing {

struct PointHash {
  std::size_t operator()(const Point& p) const {
    std::uint64_t h = 0;
    for (int c = 0; c < 3; ++c) {
      h = (h ^ std::bit_cast<std::uint64_t>(p[c])) * 0x9E3779B97F4A7C15u;
      h ^= h >> 29;
    }
    return h;
  }
};

/// Numbers points so that equal ones (to the last bit; -0 is 0) have one number.
class PointMerger {
 public:
  explicit PointMerger(std::vector<Point>& points) : points_(points) {}

  std::uint32_t index(Point p) {
    for (int c = 0; c < 3; ++c) p[c] += 0.0;  // turns -0 into 0
    const auto [at, is_new] = indices_.try_emplace(p, static_cast<std::uint32_t>(points_.size()));
    if (is_new) points_.push_back(p);
    return at->second;
  }
  void reserve(std::size_t n) { indices_.reserve(n); }

 private:
  std::vector<Point>& points_;
  std::unordered_map<Point, std::uint32_t, PointHash> indices_;
};

}  // namespace weft::meshing

// Of many flat triangles the one closest to a point, whichever others there are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/point.h"
#include "meshing/geometry/model/closest_tree.h"

namespace weft::meshing {

/// Immutable; of equally near triangles the one of the lowest number is the closest. So what is found in
/// several sets is, when compared by before(), what is found in all of them together, bit by bit.
class ClosestTriangles {
 public:
  struct Triangle {
    std::uint64_t number;  ///< less than kNone
    std::array<Point, 3> corners;
  };
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

  struct Found {
    /// Not less than the computed distance from any box around the triangle, so that boxes leave out nothing.
    double distance2 = std::numeric_limits<double>::infinity();
    std::uint64_t number = kNone;
    Vec way{};  ///< from the closest point of the triangle
    bool before(const Found& other) const {
      return distance2 != other.distance2 ? distance2 < other.distance2 : number < other.number;
    }
  };

  /// O(n log n).
  explicit ClosestTriangles(std::vector<Triangle> triangles);

  /// Of what is at most sqrt(limit2) from p the closest; else the limit and kNone.
  Found closest(const Point& p, double limit2 = std::numeric_limits<double>::infinity()) const;
  /// At most so many boxes that have all triangles; none where there is no triangle.
  std::vector<Box> boxes(std::size_t most) const;

 private:
  std::vector<Triangle> triangles_;
  ClosestForest forest_;  ///< of places in triangles_
  std::uint32_t root_ = 0;
};

}  // namespace weft::meshing

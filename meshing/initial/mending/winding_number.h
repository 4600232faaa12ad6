// The generalised winding number (Jacobson, Kavan and Sorkine-Hornung 2013): how often a surface, closed or
// not, goes around a point.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Triangles far away count as one dipole a box (Barill et al. 2018). Immutable once built.
class WindingNumber {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// `sheets`: how many times each triangle counts. `points` and `triangles` must outlive this.
  WindingNumber(std::span<const Point> points, std::span<const Triangle> triangles,
                std::span<const std::int32_t> sheets);

  /// At a place off the surface, or in the middle of triangle `on`, which counts for nothing there: half of
  /// the sum of what it is on both sides.
  double at(const Point& p, std::uint32_t on = kNone) const;

 private:
  struct Node {
    Box box;
    Point centre;                        ///< of the areas
    Vec dipole;                          ///< sum of area times normal
    double radius = 0;                   ///< of the box around the centre
    std::uint32_t first = 0, count = 0;  ///< of a leaf: in order_; else the first of two children
  };
  void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end);
  void summarise(Node& node, std::uint32_t begin, std::uint32_t end) const;
  double solid_angle(std::uint32_t t, const Point& p) const;

  std::span<const Point> points_;
  std::span<const Triangle> triangles_;
  std::span<const std::int32_t> sheets_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace weft::meshing

// How far points are from a set of triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

class SurfaceDistance {
 public:
  /// Not empty. What is given must outlive this.
  SurfaceDistance(std::span<const Point> points, std::span<const Triangle> triangles);

  double from(const Point& p) const;
  /// The largest of some places on a triangle: corners, middles of edges, centroid.
  double from(const std::array<Point, 3>& triangle) const;

 private:
  std::array<Point, 3> corners(std::uint32_t t) const;
  void build(std::size_t node, std::size_t begin, std::size_t end);
  void descend(std::size_t node, std::size_t begin, std::size_t end, const Point& p, double& best) const;

  std::span<const Point> points_;
  std::span<const Triangle> triangles_;
  std::vector<std::uint32_t> order_;
  std::vector<Box> nodes_;  ///< a balanced tree: node n splits its part of order_ at the middle
};

}  // namespace weft::meshing

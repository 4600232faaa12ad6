// Wanted sizes inside a volume, from the edges of its surface: the point-distribution function of initial
// meshes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/box.h"
#include "meshing/mesh_data.h"
#include "meshing/metric_field.h"

namespace weft::meshing {

/// h(x) = min(size, min over surface vertices w of h_w + (growth - 1) |x - w|), h_w the mean length of the
/// edges at w: neighbouring edges grow by the factor `growth` away from the surface. Immutable.
class PointDistribution {
 public:
  /// `mesh`: its triangles are the surface. `size`: 0 for no limit.
  PointDistribution(const MeshData& mesh, double growth, double size);

  double operator()(const Point& p) const;
  /// Isotropic metrics at the points, of sizes `factor` times h. Multithreaded on TBB.
  LogMetricField sample(std::span<const Point> points, double factor) const;

 private:
  struct Source {
    Point at;
    double size;
  };
  /// A node of the tree over sources [begin, end), which splits at the middle.
  struct Node {
    Box box;
    double least_size;
  };
  static constexpr std::size_t kLeaf = 8;
  void build(std::size_t node, std::size_t begin, std::size_t end);
  void search(std::size_t node, std::size_t begin, std::size_t end, const Point& p, double& best) const;
  double bound(std::size_t node, const Point& p) const;

  std::vector<Source> sources_;
  std::vector<Node> nodes_;
  double slope_, size_;
};

}  // namespace weft::meshing

// Wanted sizes inside a volume, from the edges of its surface: the point-distribution function of initial
// meshes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/initial/spread_sizes.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"

namespace weft::meshing {

/// h(x) = min(size, min over surface vertices w of h_w + s_w |x - w|), h_w the mean length of the edges at w,
/// s_w = growth - 1: neighbouring edges grow by the factor `growth` away from the surface. Immutable.
///
/// A surface that is kept may grow faster than `growth`, or be fine on one side of a thin gap and coarse on
/// the other; its large triangles must not stand among points that are far too dense for them. For such, s_w
/// is at least the steepest way from w to any surface vertex v, (h_v - h_w) / max(|v - w|, h_w), up to 0.6
/// (size_sources).
class PointDistribution {
 public:
  /// `mesh`: its triangles are the surface. `size`: 0 for no limit.
  PointDistribution(const MeshData& mesh, double growth, double size);

  double operator()(const Point& p) const;
  /// Isotropic metrics at the points, of sizes `factor` times h. Multithreaded on TBB.
  LogMetricField sample(std::span<const Point> points, double factor) const;
  /// h_w and s_w of a surface that is kept, to be spread within the volume (spread_sizes.h).
  std::vector<SizeSource> size_sources() const;

 private:
  struct Source {
    Point at;
    double size;
    std::uint32_t vertex;
  };
  /// A node of the tree over sources [begin, end), which splits at the middle.
  struct Node {
    Box box;
    double least_size, largest_size;
  };
  static constexpr std::size_t kLeaf = 8;
  void build(std::size_t node, std::size_t begin, std::size_t end);
  double steepest(const Source& from) const;
  void search_steepest(std::size_t node, std::size_t begin, std::size_t end, const Source& from,
                       double& best) const;
  void search(std::size_t node, std::size_t begin, std::size_t end, const Point& p, double& best) const;
  double bound(std::size_t node, const Point& p) const;

  std::vector<Source> sources_;
  std::vector<Node> nodes_;
  double slope_, size_;
};

}  // namespace weft::meshing

// The metric of first layers at walls.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// At distance d from the nearest wall the size across it is h(d) = height + (growth - 1) d, the continuous
/// form of layers that grow geometrically, and along it the larger of `tangential` and h(d); none is larger
/// than largest_size. The direction across is that to the nearest point of the walls, of equally near
/// triangles on the first of the mesh, and on a wall its normal; where walls meet at an angle the demands of
/// all of them are intersected. O((n + w) log w) for w wall triangles; multithreaded; does not depend on the
/// number of threads. Throws what check_walls() throws.
LogMetricField wall_metric(const MeshData& mesh, const WallOptions& options);

/// Throws InputError naming a reference for which has_triangle() is false, and for a height that is not
/// positive or a growth below 1.
void check_walls(const WallOptions& options, const std::function<bool(std::int32_t)>& has_triangle);

inline bool is_wall(const WallOptions& options, std::int32_t triangle_ref) {
  return std::ranges::find(options.refs, triangle_ref) != options.refs.end();
}

/// What walls ask for at one point, for who has the triangles of walls at vertices and finds the closest
/// ones: parts of a mesh, too.
class WallDemand {
 public:
  /// A triangle of walls at one of its vertices.
  struct Corner {
    std::uint32_t vertex;
    Vec area;  ///< of any sign
  };

  /// `largest`: largest_size() of the whole mesh; the options must outlive the object. Of the vertices that
  /// are asked for all `corners` are there, in the order of the mesh's triangles.
  WallDemand(const WallOptions& options, double largest, std::vector<Corner> corners);

  /// Where no wall is.
  LogMetric anywhere() const;
  bool on_wall(std::uint32_t vertex) const { return !corners_at(vertex).empty(); }
  LogMetric at_vertex(std::uint32_t vertex) const;
  /// At a vertex on no wall; `way`: to it from the closest point of all walls.
  LogMetric at_way(const Vec& way) const;

 private:
  std::span<const Corner> corners_at(std::uint32_t vertex) const;
  LogMetric in_layer(const Vec& direction, double distance) const;

  const WallOptions& options_;
  double largest_;
  std::vector<Corner> corners_;  ///< ascending by vertex
};

/// The corners of a triangle, whose vertices have any numbers.
void add_corners(const Triangle& vertices, const std::array<Point, 3>& points,
                 std::vector<WallDemand::Corner>& corners);

}  // namespace weft::meshing

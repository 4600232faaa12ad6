// First layers at walls: distances and directions from the nearest wall triangle.
#include "meshing/metric/sources/wall_metric.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/geometry/surface/closest_triangles.h"

namespace weft::meshing {
namespace {

/// The metric of size `across` along the unit vector n and `along` in all directions square to it.
Metric layered(const Vec& n, double across, double along) {
  const double a = 1 / (across * across), t = 1 / (along * along);
  return identity_tensor(t) +
         (a - t) * SymTensor{n.x * n.x, n.x * n.y, n.y * n.y, n.x * n.z, n.y * n.z, n.z * n.z};
}

}  // namespace

void check_walls(const WallOptions& options, const std::function<bool(std::int32_t)>& has_triangle) {
  if (!(options.height > 0)) throw InputError("", "wall", "the height of the first layer is not positive");
  if (!(options.growth >= 1)) throw InputError("", "wall", "the growth of the layers is below 1");
  for (const std::int32_t ref : options.refs)
    if (!has_triangle(ref))
      throw InputError("", "wall " + std::to_string(ref), "no triangle has this reference");
}

void add_corners(const Triangle& vertices, const std::array<Point, 3>& points,
                 std::vector<WallDemand::Corner>& corners) {
  const Vec area = cross(points[1] - points[0], points[2] - points[0]);
  for (const std::uint32_t v : vertices) corners.push_back({v, area});
}

WallDemand::WallDemand(const WallOptions& options, double largest, std::vector<Corner> corners)
    : options_(options), largest_(largest), corners_(std::move(corners)) {
  std::ranges::stable_sort(corners_, {}, &Corner::vertex);
}

LogMetric WallDemand::anywhere() const { return identity_tensor(-2 * std::log(largest_)); }

std::span<const WallDemand::Corner> WallDemand::corners_at(std::uint32_t vertex) const {
  return std::ranges::equal_range(corners_, vertex, {}, &Corner::vertex);
}

LogMetric WallDemand::in_layer(const Vec& direction, double distance) const {
  const double across = std::min(options_.height + (options_.growth - 1) * distance, largest_);
  const double tangential = options_.tangential > 0 ? options_.tangential : largest_;
  return log_of(layered(direction, across, std::max(across, std::min(tangential, largest_))));
}

/// Of every group of wall triangles whose normals agree within 30 degrees, one demand.
LogMetric WallDemand::at_vertex(std::uint32_t vertex) const {
  constexpr double kSameWall = 0.866;
  std::vector<Vec> normals;  // sums of area vectors
  for (const Corner& corner : corners_at(vertex)) {
    const Vec& area = corner.area;
    const auto alike = [&](const Vec& n) {
      return std::abs(dot(n, area)) >= kSameWall * norm(n) * norm(area);
    };
    const auto group = std::find_if(normals.begin(), normals.end(), alike);
    if (group == normals.end())
      normals.push_back(area);
    else
      *group += (dot(*group, area) < 0 ? -1.0 : 1.0) * area;
  }
  Metric metric = identity_tensor(1 / (largest_ * largest_));
  for (const Vec& n : normals)
    if (norm(n) > 0) metric = intersect(metric, exp_exact(in_layer((1 / norm(n)) * n, 0)));
  return log_of(metric);
}

LogMetric WallDemand::at_way(const Vec& way) const {
  const double distance = norm(way);
  return distance > 0 ? in_layer((1 / distance) * way, distance) : in_layer({0, 0, 1}, 0);
}

LogMetricField wall_metric(const MeshData& mesh, const WallOptions& options) {
  check_walls(options, [&](std::int32_t ref) {
    return std::ranges::find(mesh.triangle_refs, ref) != mesh.triangle_refs.end();
  });
  std::vector<ClosestTriangles::Triangle> triangles;
  std::vector<WallDemand::Corner> corners;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!is_wall(options, mesh.triangle_refs[t])) continue;
    const auto& [a, b, c] = mesh.triangles[t];
    triangles.push_back({t, {mesh.points[a], mesh.points[b], mesh.points[c]}});
    add_corners(mesh.triangles[t], triangles.back().corners, corners);
  }
  const ClosestTriangles walls(std::move(triangles));
  const WallDemand demand(options, largest_size(mesh), std::move(corners));
  LogMetricField field(mesh.points.size(), demand.anywhere());
  if (options.refs.empty()) return field;
  for_each_index(field.size(), [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    field[i] = demand.on_wall(v) ? demand.at_vertex(v) : demand.at_way(walls.closest(mesh.points[i]).way);
  });
  return field;
}

}  // namespace weft::meshing

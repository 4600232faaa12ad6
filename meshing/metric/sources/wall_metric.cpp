// First layers at walls: distances and directions from the nearest wall triangle.
#include "meshing/metric/sources/wall_metric.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/geometry/model/closest_tree.h"
#include "meshing/geometry/surface/curved_triangle.h"

namespace weft::meshing {
namespace {

void check(const WallOptions& options, const MeshData& mesh) {
  if (!(options.height > 0)) throw InputError("", "wall", "the height of the first layer is not positive");
  if (!(options.growth >= 1)) throw InputError("", "wall", "the growth of the layers is below 1");
  for (const std::int32_t ref : options.refs)
    if (std::ranges::find(mesh.triangle_refs, ref) == mesh.triangle_refs.end())
      throw InputError("", "wall " + std::to_string(ref), "no triangle has this reference");
}

/// The metric of size `across` along the unit vector n and `along` in all directions square to it.
Metric layered(const Vec& n, double across, double along) {
  const double a = 1 / (across * across), t = 1 / (along * along);
  return identity_tensor(t) +
         (a - t) * SymTensor{n.x * n.x, n.x * n.y, n.y * n.y, n.x * n.z, n.y * n.z, n.z * n.z};
}

class Walls {
 public:
  Walls(const MeshData& mesh, const WallOptions& options, double largest)
      : mesh_(mesh), options_(options), largest_(largest), begins_(mesh.points.size() + 1, 0) {
    collect();
    file_by_vertex();
    std::vector<ClosestForest::Item> items;
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
      Box box;
      for (const std::uint32_t v : mesh_.triangles[triangles_[i]]) box.include(mesh_.points[v]);
      items.push_back({box, i});
    }
    root_ = forest_.add(items);
  }

  LogMetric demand(std::uint32_t v) const {
    return begins_[v] < begins_[v + 1] ? demand_on_wall(v) : demand_at(mesh_.points[v]);
  }

 private:
  void collect() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      if (std::ranges::find(options_.refs, mesh_.triangle_refs[t]) != options_.refs.end())
        triangles_.push_back(t);
  }
  void file_by_vertex() {
    for (const std::uint32_t t : triangles_)
      for (const std::uint32_t v : mesh_.triangles[t]) ++begins_[v + 1];
    for (std::size_t v = 1; v < begins_.size(); ++v) begins_[v] += begins_[v - 1];
    at_vertex_.resize(begins_.back());
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    for (const std::uint32_t t : triangles_)
      for (const std::uint32_t v : mesh_.triangles[t]) at_vertex_[next[v]++] = t;
  }

  std::array<Point, 3> corners(std::uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    return {mesh_.points[a], mesh_.points[b], mesh_.points[c]};
  }
  LogMetric in_layer(const Vec& direction, double distance) const {
    const double across = std::min(options_.height + (options_.growth - 1) * distance, largest_);
    const double tangential = options_.tangential > 0 ? options_.tangential : largest_;
    return log_of(layered(direction, across, std::max(across, std::min(tangential, largest_))));
  }

  /// Of every group of wall triangles at v whose normals agree within 30 degrees, one demand.
  LogMetric demand_on_wall(std::uint32_t v) const {
    constexpr double kSameWall = 0.866;
    std::vector<Vec> normals;  // sums of area vectors
    for (std::size_t i = begins_[v]; i < begins_[v + 1]; ++i) {
      const auto [a, b, c] = corners(at_vertex_[i]);
      const Vec area = cross(b - a, c - a);
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

  LogMetric demand_at(const Point& p) const {
    const auto nearest = [&](std::uint32_t i) {
      const auto [a, b, c] = corners(triangles_[i]);
      return closest_point(a, b, c, p);
    };
    const std::uint32_t i =
        forest_.closest(root_, p, [&](std::uint32_t item) { return nearest(item).distance2; });
    const auto [a, b, c] = corners(triangles_[i]);
    const Barycentric at = nearest(i).at;
    const Vec way = p - (at[0] * a + at[1] * b + at[2] * c);
    const double distance = norm(way);
    return distance > 0 ? in_layer((1 / distance) * way, distance) : in_layer({0, 0, 1}, 0);
  }

  const MeshData& mesh_;
  const WallOptions& options_;
  double largest_;
  std::vector<std::uint32_t> triangles_;  ///< of the walls
  std::vector<std::size_t> begins_;       ///< of each vertex in at_vertex_
  std::vector<std::uint32_t> at_vertex_;  ///< wall triangles
  ClosestForest forest_;                  ///< of positions in triangles_
  std::uint32_t root_ = 0;
};

}  // namespace

LogMetricField wall_metric(const MeshData& mesh, const WallOptions& options, std::optional<double> given) {
  check(options, mesh);
  const double largest = given.value_or(largest_size(mesh));
  LogMetricField field(mesh.points.size());
  if (options.refs.empty()) {
    std::ranges::fill(field, identity_tensor(-2 * std::log(largest)));
    return field;
  }
  const Walls walls(mesh, options, largest);
  for_each_index(field.size(),
                 [&](std::size_t v) { field[v] = walls.demand(static_cast<std::uint32_t>(v)); });
  return field;
}

}  // namespace weft::meshing

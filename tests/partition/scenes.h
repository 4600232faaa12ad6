// Small bodies of all kinds with a metric, and ways to cut them: what the steps of the distributed method are
// tried on.
#pragma once

#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/partition/cut.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::support {

/// Two boxes apart.
inline MeshData two_bodies(std::uint32_t cells) {
  const MeshData one = unit_cube(cells);
  std::vector<Point> points = one.points;
  std::vector<std::array<std::uint32_t, 4>> tets = one.tets;
  const auto n = static_cast<std::uint32_t>(points.size());
  for (const Point& p : one.points) points.push_back(p + Point{1.5, 0.25, 0});
  for (auto tet : one.tets) {
    for (std::uint32_t& v : tet) v += n;
    tets.push_back(tet);
  }
  return mesh_of(std::move(points), std::move(tets));
}

/// An anisotropic metric that wants edges of about `size` and varies smoothly, with some noise.
inline meshing::LogMetricField wanted_sizes(const MeshData& mesh, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> slope(-0.7, 0.7), noise(-0.1, 0.1);
  std::array<Point, 6> slopes;
  for (Point& s : slopes) s = {slope(random), slope(random), slope(random)};
  const double middle = -2 * std::log(size);
  meshing::LogMetricField field;
  for (const Point& p : mesh.points) {
    const auto at = [&](int i) { return dot(slopes[i], p) + noise(random); };
    field.push_back({middle + at(0), 0.5 * at(1), middle + at(2), 0.5 * at(3), 0.5 * at(4), middle + at(5)});
  }
  return field;
}

/// A body, its metric and who has which tet.
struct Scene {
  std::string name;
  MeshData mesh;
  meshing::LogMetricField log_metrics;
  std::vector<partition::SubdomainId> part;
  std::uint32_t subdomains = 1;
  bool curved = false;  ///< volumes and areas may change a little

  Cut cut() const { return Cutting(mesh, log_metrics, part, 45).cut(subdomains); }
  double hausd() const { return curved ? 0.02 : 0.002; }
};

inline constexpr unsigned kBodies = 6;

/// The body of a seed, its tets and points in no order.
inline Scene random_body(unsigned seed) {
  std::mt19937 random(seed);
  Scene scene;
  switch (seed % kBodies) {
    case 0:
      scene = {"layers of materials", layered_box(3, 2, 3), {}, {}, 1, false};
      break;
    case 1:
      scene = {"box with required entities", unit_cube(4), {}, {}, 1, false};
      break;
    case 2:
      scene = {"ball", ball(1, 2), {}, {}, 1, true};
      break;
    case 3:
      scene = {"cylinder", cylinder(9, 2, 3, 1.5), {}, {}, 1, true};
      break;
    case 4:
      scene = {"two bodies", two_bodies(3), {}, {}, 1, false};
      break;
    default:
      scene = {"touching cells", touching_cells(4, seed), {}, {}, 1, false};
  }
  jitter_interior(scene.mesh, 0.02, seed);
  shuffle(scene.mesh, seed);
  if (seed % kBodies != 1) return scene;
  const auto some = [&](std::size_t count, std::vector<std::uint32_t>& list) {
    for (std::uint32_t i = 0; i < count; ++i)
      if (random() % 20 == 0) list.push_back(i);
  };
  some(scene.mesh.points.size(), scene.mesh.required_points);
  some(scene.mesh.triangles.size(), scene.mesh.required_triangles);
  some(scene.mesh.edges.size(), scene.mesh.required_edges);
  return scene;
}

inline Point centre_of(const MeshData& mesh, const std::array<std::uint32_t, 4>& tet) {
  Point centre;
  for (const std::uint32_t v : tet) centre += 0.25 * mesh.points[v];
  return centre;
}

/// Three ways to cut: near random places (a good decomposition), in slabs, and every tet for itself.
inline void cut_at_random(Scene& scene, std::uint32_t subdomains, unsigned way, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Point> centres, places;
  for (const auto& tet : scene.mesh.tets) centres.push_back(centre_of(scene.mesh, tet));
  for (std::uint32_t s = 0; s < subdomains; ++s) places.push_back(centres[random() % centres.size()]);
  double low = centres[0].x, high = low;
  for (const Point& c : centres) low = std::min(low, c.x), high = std::max(high, c.x);
  scene.subdomains = subdomains;
  scene.part.clear();
  for (const Point& c : centres) {
    const auto nearest = std::min_element(places.begin(), places.end(), [&](const Point& a, const Point& b) {
      return norm2(a - c) < norm2(b - c);
    });
    const double slab = (c.x - low) / (high - low) * 0.9999 * subdomains;
    scene.part.emplace_back(way == 0   ? static_cast<std::uint32_t>(nearest - places.begin())
                            : way == 1 ? static_cast<std::uint32_t>(slab)
                                       : static_cast<std::uint32_t>(random() % subdomains));
  }
  constexpr const char* kWays[] = {"places", "slabs", "scattered"};
  scene.name += ", " + std::to_string(subdomains) + " subdomains: " + kWays[way];
}

/// Everything by one seed; `finer`: how much smaller than the body's edges the wanted sizes are.
inline Scene random_scene(unsigned seed, double finer) {
  Scene scene = random_body(seed);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.35 / finer, seed);
  constexpr std::uint32_t kCounts[] = {5, 2, 12, 1, 8, 40, 3};
  cut_at_random(scene, kCounts[seed % 7], seed / kBodies % 3, seed);
  return scene;
}

}  // namespace weft::support

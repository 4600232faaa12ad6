// Random meshes with all that distribution has to carry: materials, features, required entities, gaps.
#pragma once

#include <random>

#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::support {

inline meshing::LogMetricField random_metrics(const meshing::MeshData& mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  meshing::LogMetricField field;
  for (const Point& p : mesh.points)
    field.push_back({4 - 3 * p.x + u(random), u(random), 4 + u(random), u(random), u(random), 4 + u(random)});
  return field;
}

/// Removes each element of `list` with probability `share`.
template <class T>
void thin_out(std::vector<T>& list, std::vector<std::int32_t>& refs, double share, std::mt19937& random) {
  std::bernoulli_distribution drop(share);
  std::vector<T> kept;
  std::vector<std::int32_t> kept_refs;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (drop(random)) continue;
    kept.push_back(list[i]);
    kept_refs.push_back(refs[i]);
  }
  list = std::move(kept);
  refs = std::move(kept_refs);
}

/// Each index below `count` with probability `share`.
inline std::vector<std::uint32_t> some_of(std::size_t count, double share, std::mt19937& random) {
  std::bernoulli_distribution pick(share);
  std::vector<std::uint32_t> result;
  for (std::uint32_t i = 0; i < count; ++i)
    if (pick(random)) result.push_back(i);
  return result;
}

/// One of several shapes, shuffled, with listed and required entities of all kinds and, by `seed`, with
/// missing and repeated triangles, edges inside, and points of no tet.
inline MetricMesh random_metric_mesh(unsigned seed) {
  std::mt19937 random(seed);
  MeshData mesh;
  switch (seed % 4) {
    case 0:
      mesh = layered_box(4, 2, 3);
      break;
    case 1:
      mesh = ball(1, 3);
      break;
    case 2:
      mesh = cylinder(9, 3, 4, 2.5);
      break;
    default:
      mesh = unit_cube(5);
      break;
  }
  jitter_interior(mesh, 0.01, seed);
  if (seed % 3 == 0) thin_out(mesh.triangles, mesh.triangle_refs, 0.2, random);
  if (seed % 2 == 0) {
    for (int i = 0; i < 3; ++i) {
      mesh.points.push_back({0.3 * i, 7, 1});  // of no tet
      mesh.point_refs.push_back(i);
      const auto t = random() % mesh.triangles.size();
      auto repeated = mesh.triangles[t];
      std::rotate(repeated.begin(), repeated.begin() + i, repeated.end());
      mesh.triangles.push_back(repeated);
      mesh.triangle_refs.push_back(mesh.triangle_refs[t]);
    }
    const auto& tet = mesh.tets[random() % mesh.tets.size()];
    mesh.edges.push_back({tet[0], tet[1]});  // very likely inside
    mesh.edge_refs.push_back(3);
  }
  shuffle(mesh, seed);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) mesh.point_refs[v] = static_cast<std::int32_t>(v % 5);
  mesh.corners = some_of(mesh.points.size(), 0.02, random);
  mesh.required_points = some_of(mesh.points.size(), 0.02, random);
  mesh.required_triangles = some_of(mesh.triangles.size(), 0.03, random);
  mesh.ridges = some_of(mesh.edges.size(), 0.5, random);
  mesh.required_edges = some_of(mesh.edges.size(), 0.1, random);
  auto log_metrics = random_metrics(mesh, seed);
  return {std::move(mesh), std::move(log_metrics)};
}

}  // namespace weft::support

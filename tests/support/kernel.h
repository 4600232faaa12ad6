// The kernel set up on a small mesh with one worker, and the full check of what operators leave behind.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "meshing/kernel/import_mesh.h"
#include "meshing/kernel/kernel.h"
#include "meshing/kernel/quality.h"
#include "meshing/kernel/renumber.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/background.h"
#include "meshing/metric/metric.h"
#include "meshing/metric/metric_field.h"

namespace weft::support {

/// The field that measures every length in units of `size`.
inline meshing::LogMetricField uniform_metric(const meshing::MeshData& mesh, double size) {
  return {mesh.points.size(), meshing::log_of(meshing::identity_tensor(1 / (size * size)))};
}

/// A ridge angle that makes every edge that is not perfectly flat a ridge: no boundary is curved.
inline constexpr double kFaceted = 1;

/// For claims that may be made at frozen vertices too.
inline constexpr meshing::FrozenPolicy kClaimable = meshing::FrozenPolicy::claimable;

/// A mesh in the kernel, its input as the background, and one worker, which claims as if others worked too.
class KernelRig {
 public:
  explicit KernelRig(meshing::MeshData data, double size = 1, double ridge_angle = 45)
      : KernelRig(data, uniform_metric(data, size), ridge_angle) {}
  KernelRig(meshing::MeshData data, meshing::LogMetricField metric, double ridge_angle = 45)
      : input(std::move(data)),
        log_metrics(std::move(metric)),
        imported(meshing::import_mesh(input, ridge_angle, 8 * input.points.size() + 20000,
                                      8 * input.tets.size() + 100000)),
        mesh(*imported.mesh),
        background(input, log_metrics, meshing::build_adjacency(input.tets, input.points.size())),
        kernel{mesh, background, *imported.surface, {}},
        worker(kernel, 1, false) {
    meshing::read_metric(mesh, background, true);
    kernel.limits.hausd = 0.01;
    judge_by(meshing::MetricMean::arithmetic);
  }

  void judge_by(meshing::MetricMean mean) {
    kernel.policy.mean = mean;
    for (const meshing::TetId t : live_tets()) {
      mesh.set_quality(t, static_cast<float>(meshing::judge_quality(mean, mesh, mesh.vertices(t))));
    }
  }

  std::vector<meshing::TetId> live_tets() const {
    std::vector<meshing::TetId> tets;
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
      if (mesh.alive(meshing::TetId(i))) tets.emplace_back(i);
    return tets;
  }
  std::vector<meshing::VertexId> live_vertices() const {
    std::vector<meshing::VertexId> vertices;
    for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
      if (mesh.alive(meshing::VertexId(i))) vertices.emplace_back(i);
    return vertices;
  }
  /// A tet with both vertices; invalid where they are not joined.
  meshing::TetId tet_with(meshing::VertexId a, meshing::VertexId b) const {
    for (const meshing::TetId t : live_tets())
      if (mesh.local_index(t, a) >= 0 && mesh.local_index(t, b) >= 0) return t;
    return {};
  }
  /// The live vertex nearest to a place.
  meshing::VertexId vertex_at(const meshing::Point& p) const {
    meshing::VertexId nearest;
    for (const meshing::VertexId v : live_vertices())
      if (!nearest.valid() || norm2(mesh.point(v) - p) < norm2(mesh.point(nearest) - p)) nearest = v;
    return nearest;
  }
  /// Neighbours of a vertex, each once.
  std::vector<meshing::VertexId> neighbours_of(meshing::VertexId v) const {
    std::vector<meshing::VertexId> found;
    for (const meshing::TetId t : live_tets())
      if (mesh.local_index(t, v) >= 0)
        for (const meshing::VertexId u : mesh.vertices(t))
          if (u != v) found.push_back(u);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// Closes the holes and returns the mesh as plain arrays. Ids change.
  meshing::MeshData export_data() {
    meshing::renumber_along_curve(mesh);
    worker.free_tets.clear();
    worker.free_vertices.clear();
    meshing::MeshData data;
    meshing::LogMetricField metrics;
    meshing::export_mesh(mesh, *imported.surface, imported.patch_required, data, metrics);
    EXPECT_EQ(metrics.size(), data.points.size());
    return data;
  }

  meshing::MeshData input;
  meshing::LogMetricField log_metrics;
  meshing::ImportedMesh imported;
  meshing::TetMesh& mesh;
  meshing::Background background;
  meshing::Kernel kernel;
  meshing::Worker worker;
};

/// Length of the edges by reference.
inline std::map<std::int32_t, double> length_by_ref(const meshing::MeshData& mesh) {
  std::map<std::int32_t, double> length;
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    length[mesh.edge_refs[e]] += norm(mesh.points[mesh.edges[e][1]] - mesh.points[mesh.edges[e][0]]);
  return length;
}

/// Same keys, and values equal to 1e-9 relative.
inline void expect_same_sums(const std::map<std::int32_t, double>& now,
                             const std::map<std::int32_t, double>& before, const std::string& what) {
  for (const auto& [ref, sum] : before) {
    const auto at = now.find(ref);
    ASSERT_NE(at, now.end()) << what << " of reference " << ref << " is gone";
    EXPECT_NEAR(at->second, sum, 1e-9 * sum) << what << " of reference " << ref;
  }
  EXPECT_EQ(now.size(), before.size()) << what << ": references appeared";
}

/// The lengths of the input's edges by reference. Features that the input does not list have reference 0.
inline void expect_same_lengths(const meshing::MeshData& mesh, const meshing::MeshData& input) {
  auto now = length_by_ref(mesh);
  const auto before = length_by_ref(input);
  if (!before.contains(0)) now.erase(0);
  expect_same_sums(now, before, "length");
}

/// Conforming, and the volumes and areas of `input` by reference to 1e-9: for meshes with planar boundary.
inline void expect_same_domain(const meshing::MeshData& mesh, const meshing::MeshData& input) {
  const meshing::CheckReport now = check_mesh(mesh), before = check_mesh(input);
  for (const std::string& problem : now.problems) ADD_FAILURE() << problem;
  EXPECT_EQ(now.num_components, before.num_components);
  EXPECT_EQ(now.unreferenced_points, 0u);
  EXPECT_EQ(now.touching_edges, before.touching_edges);
  EXPECT_EQ(now.touching_vertices, before.touching_vertices);
  EXPECT_NEAR(now.volume, before.volume, 1e-9 * before.volume);
  expect_same_sums(now.volume_by_ref, before.volume_by_ref, "volume");
  expect_same_sums(now.area_by_ref, before.area_by_ref, "area");
}

/// Every pointer, cached value and claim of the kernel's mesh is right.
inline void expect_sound(const meshing::TetMesh& mesh, bool cached_qualities = true,
                         meshing::MetricMean mean = meshing::MetricMean::arithmetic) {
  using namespace meshing;
  auto& claims = const_cast<TetMesh&>(mesh);
  std::size_t wrong_neighbours = 0, wrong_patches = 0, wrong_qualities = 0, dead_vertices = 0,
              wrong_kinds = 0;
  std::vector<bool> used(mesh.vertex_slots(), false);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    const TetVertices v = mesh.vertices(t);
    for (int f = 0; f < 4; ++f) {
      used[v[f].value] = true;
      dead_vertices += !mesh.alive(v[f]);
      const TetFace n = mesh.neighbour(t, f);
      if (mesh.patch(t, f).valid())
        for (const int k : kTetFaces[f]) wrong_kinds += mesh.kind(v[k]) == VertexKind::interior;
      if (!n.valid()) {
        wrong_patches += !mesh.patch(t, f).valid();
        continue;
      }
      if (!mesh.alive(n.tet()) || !(mesh.neighbour(n.tet(), n.face()) == TetFace(t, f))) {
        ++wrong_neighbours;
        continue;
      }
      for (const int k : kTetFaces[f]) wrong_neighbours += mesh.local_index(n.tet(), v[k]) < 0;
      wrong_neighbours += mesh.local_index(n.tet(), v[f]) >= 0;
      wrong_patches += mesh.patch(t, f) != mesh.patch(n.tet(), n.face());
      wrong_patches += mesh.ref(t) != mesh.ref(n.tet()) && !mesh.patch(t, f).valid();
    }
    const double q = judge_quality(mean, mesh, v);
    EXPECT_GT(q, 0) << "of tet " << t;
    if (cached_qualities) wrong_qualities += std::abs(q - mesh.quality(t)) > 1e-6 + 1e-4 * q;
  }
  EXPECT_EQ(wrong_neighbours, 0u);
  EXPECT_EQ(wrong_patches, 0u);
  EXPECT_EQ(wrong_kinds, 0u) << "corners of boundary faces called interior";
  EXPECT_EQ(wrong_qualities, 0u);
  EXPECT_EQ(dead_vertices, 0u);
  std::size_t lost = 0, wrong_tets = 0, held = 0;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) {
    const VertexId v(i);
    held += claims.claim_word(v) != TetMesh::kFree && !mesh.frozen(v);
    if (!mesh.alive(v)) continue;
    lost += !used[i];
    wrong_tets += !mesh.alive(mesh.tet_of(v)) || mesh.local_index(mesh.tet_of(v), v) < 0;
  }
  EXPECT_EQ(lost, 0u) << "live vertices of no tet";
  EXPECT_EQ(wrong_tets, 0u) << "vertices whose tet does not have them";
  EXPECT_EQ(held, 0u) << "vertices still claimed";
  for (const auto& e : mesh.feature_edges()) {
    EXPECT_TRUE(mesh.alive(e.a) && mesh.alive(e.b));
    EXPECT_GE(mesh.kind(e.a), VertexKind::ridge);
    EXPECT_GE(mesh.kind(e.b), VertexKind::ridge);
  }
}

}  // namespace weft::support

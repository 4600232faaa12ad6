// Tets eight at a time beside the judges of single tets and edges.
#include "meshing/kernel/tet_batch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::tet_batch_test {
namespace {

using support::KernelRig;

void expect_as_single_tets(const KernelRig& rig, double short_edge, double long_edge) {
  TetBatch batch(rig.mesh, short_edge, long_edge);
  std::vector<TetId> seen;
  const auto visit = [&](const SeenTet& s) {
    seen.push_back(s.tet);
    EXPECT_EQ(s.vertices, rig.mesh.vertices(s.tet));
    const double quality = judge_quality(MetricMean::arithmetic, rig.mesh, s.vertices);
    EXPECT_NEAR(s.quality, quality, 1e-11 * std::abs(quality));
    std::uint8_t short_edges = 0;
    bool has_long = false;
    for (std::size_t e = 0; e < 6; ++e) {
      const auto& [a, b, c, d] = kTetEdges[e];
      const MetricLength length = edge_between(rig.mesh, s.vertices[a], s.vertices[b]);
      short_edges = static_cast<std::uint8_t>(short_edges | (length.below(short_edge) ? 1u << e : 0));
      has_long |= length.above(long_edge);
    }
    EXPECT_EQ(s.short_edges, short_edges);
    EXPECT_EQ(s.has_long_edge, has_long);
  };
  const std::vector<TetId> tets = rig.live_tets();
  for (const TetId t : tets) {
    batch.add(t);
    if (batch.full()) batch.take(visit);
  }
  batch.take(visit);
  batch.take(visit);  // empty now
  EXPECT_EQ(seen, tets);
}

TEST(TetBatch, SeesWhatTheJudgesOfSingleTetsSee) {
  MeshData mesh = support::unit_cube(3);
  support::jitter_interior(mesh, 0.1);
  LogMetricField field(mesh.points.size());
  for (std::size_t i = 0; i < field.size(); ++i) {
    const double s = std::sin(static_cast<double>(7 * i));
    field[i] = {2 + s, 0.5 * s, 1 - s, 0.3, s * s, 3};
  }
  const KernelRig rig(mesh, field);
  for (const double bound : {0.3, 0.7, 1.0, 1.4}) expect_as_single_tets(rig, bound, 1.2 * bound);
}

TEST(TetBatch, LeavesWhatIsOutOfItsRangeToTheJudges) {
  // Tets flat up to rounding; lengths far beyond what single precision can cube.
  MeshData flat = support::unit_cube(2);
  for (Point& p : flat.points) p.z *= 1e-17;
  expect_as_single_tets(KernelRig(flat, 1), 0.3, 0.7);
  expect_as_single_tets(KernelRig(support::unit_cube(2), 1e-9), 0.3, 0.7);
  expect_as_single_tets(KernelRig(support::unit_cube(2), 1e9), 0.3, 0.7);
}

}  // namespace
}  // namespace weft::meshing::tet_batch_test

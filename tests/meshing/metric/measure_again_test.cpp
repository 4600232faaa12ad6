// Measures of what a mesh has become, from those of what it was, against measuring it as a whole.
#include "meshing/metric/measure_again.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "meshing/metric/metric_field.h"
#include "tests/support/meshes.h"

namespace weft::meshing::measure_again_test {
namespace {

constexpr std::uint32_t kCells = 9;

/// Most edges are unit, a few are longer and a few shorter.
MeshData cells_of_a_cube() {
  MeshData mesh = support::unit_cube(kCells);
  support::jitter_interior(mesh, 0.1 / kCells, 3);
  return mesh;
}

LogMetricField metric_of(const MeshData& mesh) {
  const double size = 1 / (0.8 * kCells);
  LogMetricField field;
  for (const Point& p : mesh.points)
    field.push_back(LogMetric(identity_tensor(-2 * std::log(size) + 0.02 * p.x)));
  return field;
}

/// What tets have become of the old ones: some with a vertex that has moved, some gone, one come.
struct Changed {
  MeshData mesh;
  LogMetricField log_metrics;
  std::vector<std::uint32_t> origins;
};

Changed change(const MeshData& old, const LogMetricField& log_metrics, unsigned seed, std::size_t moves) {
  std::mt19937 random(seed);
  Changed c{old, log_metrics, {}};
  std::vector<bool> moved(old.points.size(), false);
  for (std::size_t i = 0; i < moves; ++i) {
    const std::size_t v = random() % old.points.size();
    c.mesh.points[v] += Vec{0.02 / kCells, -0.03 / kCells, 0.01 / kCells};
    moved[v] = true;
  }
  c.mesh.tets.clear();
  for (std::uint32_t t = 0; t < old.tets.size(); ++t) {
    if (random() % 200 == 0) continue;
    const auto& tet = old.tets[t];
    const bool same = !moved[tet[0]] && !moved[tet[1]] && !moved[tet[2]] && !moved[tet[3]];
    c.origins.push_back(same ? t : kNoOrigin);
    c.mesh.tets.push_back(tet);
  }
  c.mesh.tets.push_back(old.tets.front());
  c.origins.push_back(kNoOrigin);
  return c;
}

void expect_same(const Measures& a, const Measures& b) {
  EXPECT_EQ(a.num_vertices, b.num_vertices);
  EXPECT_EQ(a.num_tets, b.num_tets);
  EXPECT_EQ(a.num_edges, b.num_edges);
  EXPECT_EQ(a.num_triangles, b.num_triangles);
  for (const auto& [x, y] :
       {std::pair(a.volume, b.volume), std::pair(a.complexity, b.complexity),
        std::pair(a.quality_mean, b.quality_mean), std::pair(a.length_mean, b.length_mean)})
    EXPECT_NEAR(x, y, 1e-12 * std::abs(y));
  for (const auto& [x, y] :
       {std::pair(a.quality_min, b.quality_min), std::pair(a.quality_q01, b.quality_q01),
        std::pair(a.quality_q001, b.quality_q001), std::pair(a.quality_above_08, b.quality_above_08),
        std::pair(a.length_min, b.length_min), std::pair(a.length_max, b.length_max),
        std::pair(a.edges_unit, b.edges_unit), std::pair(a.edges_short, b.edges_short),
        std::pair(a.edges_long, b.edges_long)})
    EXPECT_EQ(x, y);
  for (const auto& [x, y] : {std::pair(&a.quality, &b.quality), std::pair(&a.quality_log, &b.quality_log),
                             std::pair(&a.length, &b.length), std::pair(&a.length_log, &b.length_log)}) {
    EXPECT_EQ(x->counts, y->counts);
    EXPECT_EQ(x->below, y->below);
    EXPECT_EQ(x->above, y->above);
  }
}

TEST(MeasureAgain, MeasuresAMeshAsAWhole) {
  const MeshData mesh = cells_of_a_cube();
  const LogMetricField metric = metric_of(mesh);
  expect_same(MeasuredMesh({mesh, metric}).measures(), measure(mesh, metric));
}

TEST(MeasureAgain, SaysWhatMeasuringAllOfTheResultWouldSay) {
  const MeshData old = cells_of_a_cube();
  const LogMetricField metric = metric_of(old);
  const MeasuredMesh measured({old, metric});
  ASSERT_GT(measured.measures().edges_short, 0);
  ASSERT_GT(measured.measures().edges_long, 0);
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Changed c = change(old, metric, seed, 10);
    const auto found = measured.of_result({old, metric}, {c.mesh, c.log_metrics}, c.origins);
    ASSERT_TRUE(found);
    expect_same(*found, measure(c.mesh, c.log_metrics));
  }
}

TEST(MeasureAgain, SaysNothingWhereMuchHasChangedOrEdgesAreFarFromUnit) {
  const MeshData old = cells_of_a_cube();
  const LogMetricField metric = metric_of(old);
  const Changed much = change(old, metric, 1, 300);
  EXPECT_FALSE(
      MeasuredMesh({old, metric}).of_result({old, metric}, {much.mesh, much.log_metrics}, much.origins));
  const LogMetricField fine(old.points.size(), LogMetric(identity_tensor(20)));
  const Changed little = change(old, fine, 1, 1);
  EXPECT_FALSE(MeasuredMesh({old, fine}).of_result({old, fine}, {little.mesh, fine}, little.origins));
}

}  // namespace
}  // namespace weft::meshing::measure_again_test

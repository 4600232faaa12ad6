// Tests of the measures against values known by hand.
#include "meshing/metric/measures.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "meshing/metric/metric_field.h"
#include "tests/support/meshes.h"

namespace weft::meshing::measures_test {
namespace {

using support::regular_tet;
using support::unit_cube;

std::vector<LogMetric> constant(const MeshData& mesh, const Metric& metric) {
  return std::vector<LogMetric>(mesh.points.size(), log_of(metric));
}

/// Stretches the mesh along a slanted direction: x <- S x; its own metric is then S^-2.
SymTensor stretch(MeshData& mesh, double factor) {
  const Vec n{2.0 / 3, -1.0 / 3, 2.0 / 3};
  const SymTensor along{n.x * n.x, n.x * n.y, n.y * n.y, n.x * n.z, n.y * n.z, n.z * n.z};
  for (Point& p : mesh.points) p = apply(identity_tensor() + (factor - 1) * along, p);
  return identity_tensor() + (1 / (factor * factor) - 1) * along;
}

std::uint64_t total(const Histogram& h) {
  return std::accumulate(h.counts.begin(), h.counts.end(), h.below + h.above);
}

TEST(Measures, ARegularUnitTetIsPerfect) {
  const MeshData mesh = regular_tet();
  const Measures m = measure(mesh, constant(mesh, identity_tensor()));
  EXPECT_EQ(m.num_vertices, 4u);
  EXPECT_EQ(m.num_tets, 1u);
  EXPECT_EQ(m.num_edges, 6u);
  EXPECT_EQ(m.num_triangles, 4u);
  EXPECT_NEAR(m.volume, std::sqrt(2.0) / 12, 1e-15);
  EXPECT_NEAR(m.complexity, std::sqrt(2.0) / 12, 1e-15);
  for (const double q : {m.quality_mean, m.quality_min, m.quality_q01, m.quality_q001})
    EXPECT_NEAR(q, 1, 1e-14);
  for (const double l : {m.length_mean, m.length_min, m.length_max}) EXPECT_NEAR(l, 1, 1e-14);
  EXPECT_EQ(m.edges_unit, 1);
  EXPECT_EQ(m.edges_short + m.edges_long, 0);
  EXPECT_EQ(m.quality_above_08, 1);
  EXPECT_EQ(m.quality.counts.back(), 1u);
  EXPECT_EQ(m.quality_log.counts.back() + m.quality_log.above, 1u);
}

TEST(Measures, ShapesOfARegularTetAndOfACornerOfACube) {
  const ShapeMeasures regular = measure_shape(regular_tet(1e-5));
  EXPECT_NEAR(regular.quality_min, 1, 1e-12);
  EXPECT_NEAR(regular.least_dihedral_degrees, std::acos(1.0 / 3) * 180 / std::numbers::pi, 1e-9);
  MeshData corner = regular_tet();
  corner.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const ShapeMeasures right = measure_shape(corner);
  EXPECT_NEAR(right.least_dihedral_degrees, std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi, 1e-9);
  EXPECT_NEAR(right.quality_mean, 36 / std::cbrt(3.0) * std::pow(1.0 / 6, 2.0 / 3) / 9, 1e-12);
  EXPECT_EQ(right.quality_mean, right.quality_q01);
  EXPECT_EQ(measure_shape(MeshData{}).least_dihedral_degrees, 0);
}

TEST(Measures, ASmallRegularTetIsPerfectInItsOwnMetric) {
  const MeshData mesh = regular_tet(1e-5);
  const Measures m = measure(mesh, constant(mesh, identity_tensor(1e10)));
  EXPECT_NEAR(m.quality_min, 1, 1e-12);
  EXPECT_NEAR(m.length_min, 1, 1e-12);
  EXPECT_NEAR(m.length_max, 1, 1e-12);
}

TEST(Measures, AStretchedTetIsPerfectInItsOwnMetric) {
  for (const double factor : {1e-4, 0.1, 10.0, 1e4}) {
    MeshData mesh = regular_tet();
    const Metric own = stretch(mesh, factor);
    const Measures m = measure(mesh, constant(mesh, own));
    EXPECT_NEAR(m.quality_min, 1, 1e-6) << factor;
    EXPECT_NEAR(m.length_min, 1, 1e-6) << factor;
    EXPECT_NEAR(m.length_max, 1, 1e-6) << factor;
    EXPECT_NEAR(m.complexity, std::sqrt(2.0) / 12, 1e-6) << factor;
  }
}

TEST(Measures, AStretchedTetIsPoorInTheIdentity) {
  MeshData mesh = support::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  // 36 / 3^(1/3) (1/6)^(2/3) / 9 = 2 (2/3)^(1/3) ... = 0.8399...
  const double expected = 36 / std::cbrt(3.0) * std::cbrt(1.0 / 36) / 9;
  EXPECT_NEAR(measure(mesh, constant(mesh, identity_tensor())).quality_min, expected, 1e-14);
  EXPECT_NEAR(expected, 0.8399473665965821, 1e-15);
  mesh.points[3].z = 0.01;
  const double flat = 36 / std::cbrt(3.0) * std::cbrt(1e-4 / 36) / (2 + 2 + 2 * 1.0001 + 1e-4);
  EXPECT_NEAR(measure(mesh, constant(mesh, identity_tensor())).quality_min, flat, 1e-14);
}

TEST(Measures, MeanRatioUsesTheLogEuclideanMean) {
  const MeshData mesh = regular_tet();
  // The mean of these logarithms is that of the identity, while the mean of the metrics is not.
  const LogMetric a{2, 0, -2, 0, 0, 0};
  const std::array<LogMetric, 4> logs = {a, -1.0 * a, 3.0 * a, -3.0 * a};
  EXPECT_NEAR(mean_ratio({mesh.points[0], mesh.points[1], mesh.points[2], mesh.points[3]}, logs), 1, 1e-14);
}

TEST(Measures, MeanRatioIsNegativeForAnInvertedTet) {
  const MeshData mesh = regular_tet();
  EXPECT_NEAR(mean_ratio({mesh.points[1], mesh.points[0], mesh.points[2], mesh.points[3]}, {}), -1, 1e-14);
}

TEST(Measures, EdgesUseTheExactLength) {
  const MeshData mesh = regular_tet();
  std::vector<LogMetric> logs = constant(mesh, identity_tensor());
  logs[0] = identity_tensor(2);  // size 1/e: three edges have the length (e - 1) / 1, the others 1
  const Measures m = measure(mesh, logs);
  const double e = std::exp(1.0);
  EXPECT_NEAR(m.length_max, e - 1, 1e-14);
  EXPECT_NEAR(m.length_min, 1, 1e-14);
  EXPECT_NEAR(m.length_mean, e / 2, 1e-14);
  EXPECT_DOUBLE_EQ(m.edges_long, 0.5);
  EXPECT_DOUBLE_EQ(m.edges_unit, 0.5);
}

TEST(Measures, UniformMetricsHaveTheirAnalyticComplexity) {
  MeshData mesh = unit_cube(6);
  support::jitter_interior(mesh, 0.01);
  for (const double h : {0.01, 0.5, 3.0}) {
    const auto logs = sample(AnalyticMetric("uniform:" + std::to_string(h)), mesh);
    EXPECT_NEAR(complexity(mesh, logs) * h * h * h, 1, 1e-13);
    EXPECT_EQ(measure(mesh, logs).complexity, complexity(mesh, logs));
  }
}

TEST(Measures, ComplexityWeighsVerticesByTheirVolumes) {
  const MeshData mesh = support::two_tets();
  std::vector<LogMetric> logs(5);
  logs[0] = identity_tensor(2 * std::log(2.0));  // sqrt det = 8, a quarter of both tets: 1/12
  logs[3] = identity_tensor(2 * std::log(3.0));  // sqrt det = 27, a quarter of one tet: 1/24
  EXPECT_NEAR(complexity(mesh, logs), 1.0 / 3 + 7.0 / 12 + 26.0 / 24, 1e-14);
}

TEST(Measures, CountsEveryEdgeOnceAndEveryTetInTheHistograms) {
  MeshData mesh = unit_cube(5);
  support::jitter_interior(mesh, 0.02);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& tet : mesh.tets)
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) edges.insert(std::minmax(tet[i], tet[j]));
  const Measures m = measure(mesh, sample(AnalyticMetric("polar-2"), mesh));
  EXPECT_EQ(m.num_edges, edges.size());
  EXPECT_EQ(total(m.quality), mesh.tets.size());
  EXPECT_EQ(total(m.quality_log), mesh.tets.size());
  EXPECT_EQ(total(m.length), edges.size());
  EXPECT_EQ(total(m.length_log), edges.size());
  EXPECT_NEAR(m.edges_unit + m.edges_short + m.edges_long, 1, 1e-14);
}

TEST(Measures, QuantilesAreThoseOfTheSortedQualities) {
  MeshData mesh = unit_cube(7);
  support::jitter_interior(mesh, 0.02);
  const auto logs = sample(AnalyticMetric("polar-1"), mesh);
  std::vector<double> q;
  for (const auto& [a, b, c, d] : mesh.tets)
    q.push_back(mean_ratio({mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]},
                           {logs[a], logs[b], logs[c], logs[d]}));
  std::sort(q.begin(), q.end());
  const Measures m = measure(mesh, logs);
  ASSERT_EQ(q.size(), 2058u);
  EXPECT_NEAR(m.quality_min, q.front(), 1e-12);
  EXPECT_NEAR(m.quality_q01, q[20], 1e-12);  // 20.58 tets are 1 %
  EXPECT_NEAR(m.quality_q001, q[2], 1e-12);  // 2.058 tets are 0.1 %
  EXPECT_NEAR(m.quality_mean, std::accumulate(q.begin(), q.end(), 0.0) / 2058, 1e-13);
  const auto below = [&q](double x) {
    return static_cast<double>(std::lower_bound(q.begin(), q.end(), x) - q.begin());
  };
  EXPECT_DOUBLE_EQ(m.quality_below_01, below(0.1) / 2058);
  EXPECT_DOUBLE_EQ(m.quality_below_02, below(0.2) / 2058);
  EXPECT_DOUBLE_EQ(m.quality_above_08, 1 - below(0.8) / 2058);
  EXPECT_GT(m.quality_below_02, 0);
}

TEST(Measures, AreTheSameForAnyNumberOfThreads) {
  MeshData mesh = unit_cube(24);
  support::jitter_interior(mesh, 0.004);
  support::shuffle(mesh);
  const auto logs = sample(AnalyticMetric("polar-2"), mesh);
  const Measures expected = measure(mesh, logs);
  for (const int threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Measures m = measure(mesh, logs);
    EXPECT_EQ(m.volume, expected.volume);
    EXPECT_EQ(m.complexity, expected.complexity);
    EXPECT_EQ(m.quality_mean, expected.quality_mean);
    EXPECT_EQ(m.length_mean, expected.length_mean);
    EXPECT_EQ(m.length.counts, expected.length.counts);
  }
}

TEST(Measures, OfNoMeshAreZero) {
  const Measures m = measure({}, {});
  EXPECT_EQ(m.num_tets, 0u);
  EXPECT_EQ(m.quality_mean, 0);
  EXPECT_EQ(m.length_mean, 0);
  EXPECT_EQ(m.quality.counts.size(), 100u);
}

TEST(Histogram, PutsValuesIntoTheirIntervals) {
  Histogram h{0, 1, false, std::vector<std::uint64_t>(4), 0, 0};
  for (const double x : {-0.1, 0.0, 0.25, 0.3, 0.99, 1.0, 1.1}) h.add(x);
  EXPECT_EQ(h.counts, (std::vector<std::uint64_t>{1, 2, 0, 2}));
  EXPECT_EQ(h.below, 1u);
  EXPECT_EQ(h.above, 1u);
  Histogram log{-2, 0, true, std::vector<std::uint64_t>(2), 0, 0};
  for (const double x : {-1.0, 0.0, 0.001, 0.05, 0.5, 1.0, 2.0}) log.add(x);
  EXPECT_EQ(log.counts, (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(log.below, 3u);
  EXPECT_EQ(log.above, 1u);
}

}  // namespace
}  // namespace weft::meshing::measures_test

// Tests of gradation in metric space and in mixed space.
#include "meshing/metric/gradation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>

#include "tests/support/meshes.h"

namespace weft::meshing::gradation_test {
namespace {

using support::unit_cube;

constexpr GradationSpace kSpaces[] = {GradationSpace::metric, GradationSpace::mixed};

double size_of(const LogMetric& isotropic) { return std::exp(-0.5 * isotropic.xx); }

/// What M_p demands at the other end of `edge`, by the formulas of the header.
Metric demanded(const Metric& mp, const Vec& edge, double beta, GradationSpace space) {
  const double in_metric = 1 + std::sqrt(squared_length(mp, edge)) * std::log(beta);
  Eigen3 e = eigen_decomposition(mp);
  for (double& value : e.values) {
    const double in_space = 1 + std::sqrt(value) * norm(edge) * std::log(beta);
    const double t = space == GradationSpace::mixed ? 0.125 : 0;
    value *= std::pow(std::pow(in_space, t) * std::pow(in_metric, 1 - t), -2);
  }
  return from_eigen(e);
}

/// By how much the worst edge violates gradation: the largest eigenvalue of M_q^-1 (grown M_p), less 1.
double worst_violation(const MeshData& mesh, double beta, const LogMetricField& field,
                       GradationSpace space = GradationSpace::metric) {
  double worst = -1;
  const auto visit = [&](std::uint32_t p, std::uint32_t q) {
    const Metric mp = exp_exact(field[p]), mq = exp_exact(field[q]);
    const Metric wanted = demanded(mp, mesh.points[q] - mesh.points[p], beta, space);
    // The largest s for which M_q still is at least as fine as s times the grown M_p, by bisection.
    double lo = 0, hi = 2;
    for (int i = 0; i < 40; ++i) {
      const double s = 0.5 * (lo + hi);
      const SymTensor rest = mq - s * wanted;
      (is_positive_definite(rest) ? lo : hi) = s;
    }
    worst = std::max(worst, 1 / lo - 1);
  };
  for (const auto& tet : mesh.tets)
    for (const std::uint32_t p : tet)
      for (const std::uint32_t q : tet)
        if (p != q) visit(p, q);
  return worst;
}

TEST(Gradation, EndsAfterASweepOnceItIsInterrupted) {
  const MeshData mesh = unit_cube(8);
  LogMetricField start(mesh.points.size(), LogMetric{});
  start[0] = log_of(identity_tensor(1e4));
  const std::atomic<bool> interrupt{true}, no_interrupt{false};
  for (const GradationSpace space : kSpaces) {
    LogMetricField field = start, whole = start;
    EXPECT_EQ(Gradation(WholeDomain(mesh, &interrupt), 1.2, space).limit(field), 1);
    EXPECT_GT(Gradation(WholeDomain(mesh, &no_interrupt), 1.2, space).limit(whole), 3);
    EXPECT_LT(worst_violation(mesh, 1.2, whole, space), 2e-3);
    EXPECT_GT(worst_violation(mesh, 1.2, field, space), 0.1);
    EXPECT_NE(field, start);  // what there is by then
  }
}

TEST(Gradation, LeavesAConstantFieldUnchanged) {
  MeshData mesh = unit_cube(5);
  support::jitter_interior(mesh, 0.02);
  for (const Metric& m : {identity_tensor(100), Metric{4e5, 4e5 - 10, 4e5, 0, 0, 100}}) {
    LogMetricField field(mesh.points.size(), log_of(m));
    const LogMetricField before = field;
    for (const GradationSpace space : kSpaces) EXPECT_EQ(limit_gradation(mesh, 1.2, field, space), 0);
    EXPECT_EQ(field, before);
  }
}

TEST(Gradation, AsksForNothingWhenOff) {
  const MeshData mesh = unit_cube(5);
  LogMetricField field = sample(AnalyticMetric("polar-2"), mesh);
  const LogMetricField before = field;
  for (const double beta : {-1.0, 0.0, 1.0}) EXPECT_EQ(limit_gradation(mesh, beta, field), 0);
  EXPECT_EQ(field, before);
}

TEST(Gradation, SmoothsAJumpByItsFormula) {
  const MeshData mesh = unit_cube(8);
  LogMetricField field(mesh.points.size(), identity_tensor(0));  // size 1
  std::size_t fine = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (norm(mesh.points[v] - Point{0.5, 0.5, 0.5}) < 1e-9) fine = v;
  field[fine] = identity_tensor(-2 * std::log(0.01));
  const LogMetricField before = field;
  EXPECT_GE(limit_gradation(mesh, 1.5, field), 1);
  EXPECT_EQ(field[fine], before[fine]);
  LogMetricField mixed = before;  // the two spaces are one for isotropic sizes
  limit_gradation(mesh, 1.5, mixed, GradationSpace::mixed);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    EXPECT_NEAR(size_of(mixed[v]), size_of(field[v]), 1e-9);
    // In metric space an isotropic size grows by ln(beta) per Euclidean length: h_q = h_p + d ln beta; over
    // several edges the way is at least as long as the straight line.
    const double d = norm(mesh.points[v] - mesh.points[fine]);
    EXPECT_GE(size_of(field[v]), (0.01 + d * std::log(1.5)) * (1 - 1e-3));
    EXPECT_LE(size_of(field[v]), 0.01 + 1.8 * d * std::log(1.5) + 1e-9);
  }
}

TEST(Gradation, LeavesNoEdgeThatViolatesIt) {
  MeshData mesh = unit_cube(6);
  support::jitter_interior(mesh, 0.01);
  support::shuffle(mesh);
  for (const char* name : {"polar-2", "linear"})
    for (const double beta : {1.05, 1.2})
      for (const GradationSpace space : kSpaces) {
        LogMetricField field = sample(AnalyticMetric(name), mesh);
        const LogMetricField before = field;
        EXPECT_GT(worst_violation(mesh, beta, field, space), 0.05);
        const int sweeps = limit_gradation(mesh, beta, field, space);
        EXPECT_GE(sweeps, 1);
        EXPECT_LT(sweeps, 50);
        EXPECT_LT(worst_violation(mesh, beta, field, space), 1.01e-3);
        for (std::size_t v = 0; v < field.size(); ++v)  // never coarser than before
          EXPECT_GE(trace(field[v]), trace(before[v]) - 1e-9);
      }
}

TEST(Gradation, ReachesTheEndOfALongRow) {
  BoxOptions options;
  options.cells = {200, 1, 1};
  options.max = {200, 1, 1};
  const MeshData mesh = structured_box(options);
  for (const GradationSpace space : kSpaces) {
    LogMetricField field;
    for (const Point& p : mesh.points)
      field.push_back(identity_tensor(-2 * std::log(p.x < 0.5 ? 1e-3 : 100)));
    EXPECT_GT(limit_gradation(mesh, 1.2, field, space), 190);
    EXPECT_LT(worst_violation(mesh, 1.2, field, space), 1.01e-3);
    for (std::size_t v = 0; v < field.size(); ++v)
      EXPECT_NEAR(size_of(field[v]), 1e-3 + mesh.points[v].x * std::log(1.2), 0.02 * mesh.points[v].x + 1e-9);
  }
}

TEST(Gradation, DoesNotDependOnTheThreads) {
  const MeshData mesh = unit_cube(12);
  const LogMetricField before = sample(AnalyticMetric("polar-2"), mesh);
  for (const GradationSpace space : kSpaces) {
    LogMetricField expected = before;
    limit_gradation(mesh, 1.3, expected, space);
    EXPECT_NE(expected, before);
    for (const int threads : {1, 2, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      LogMetricField field = before;
      limit_gradation(mesh, 1.3, field, space);
      EXPECT_EQ(field, expected);
    }
  }
}

TEST(Gradation, InMixedSpaceMakesMetricsRounder) {
  const MeshData mesh = unit_cube(6);
  LogMetricField field(mesh.points.size(), identity_tensor(0));
  std::size_t centre = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (norm(mesh.points[v] - Point{0.5, 0.5, 0.5}) < 1e-9) centre = v;
  field[centre] = log_of({1, 0, 1, 0, 0, 1e8});
  LogMetricField metric = field, mixed = field;
  limit_gradation(mesh, 1.5, metric, GradationSpace::metric);
  limit_gradation(mesh, 1.5, mixed, GradationSpace::mixed);
  const auto aspect = [](const LogMetric& l) {
    const Eigen3 e = eigen_decomposition(l);
    return std::exp(0.5 * (e.values[2] - e.values[0]));
  };
  double rounder = 0, vertices = 0;
  for (std::size_t v = 0; v < field.size(); ++v) {
    if (v == centre || aspect(metric[v]) < 1.5) continue;
    ++vertices;
    rounder += aspect(mixed[v]) < aspect(metric[v]);
  }
  EXPECT_GT(vertices, 10);
  EXPECT_GT(rounder / vertices, 0.9);
}

}  // namespace
}  // namespace weft::meshing::gradation_test

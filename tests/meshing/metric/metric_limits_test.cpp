// Tests of limits on metric fields and of reaching a complexity under them.
#include "meshing/metric/metric_limits.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>

#include "meshing/base/error.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_domain.h"
#include "tests/support/meshes.h"

namespace weft::meshing::metric_limits_test {
namespace {

using support::unit_cube;

void expect_within(const MetricLimits& limits, const LogMetricField& field) {
  for (const LogMetric& l : field) {
    const Eigen3 e = eigen_decomposition(l);
    const double smallest = std::exp(-0.5 * e.values[2]), largest = std::exp(-0.5 * e.values[0]);
    if (limits.hmin > 0) {
      EXPECT_GE(smallest, limits.hmin * (1 - 1e-9));
    }
    if (limits.hmax > 0) {
      EXPECT_LE(largest, limits.hmax * (1 + 1e-9));
    }
    if (limits.aspect > 1) {
      EXPECT_LE(largest / smallest, limits.aspect * (1 + 1e-9));
    }
  }
}

TEST(FitToComplexity, ReachesTheTargetWithinAllLimits) {
  MeshData mesh = unit_cube(8);
  support::jitter_interior(mesh, 0.01);
  for (const GradationSpace space : {GradationSpace::metric, GradationSpace::mixed})
    for (const MetricLimits& limits :
         {MetricLimits{0, 0, 0, 1.3, space}, MetricLimits{0.01, 0.2, 0, 1.5, space},
          MetricLimits{0, 0, 5, 0, space}, MetricLimits{0.02, 0.4, 4, 1.2, space}})
      for (const double target : {600.0, 5000.0}) {
        LogMetricField field = sample(AnalyticMetric("polar-2"), mesh);
        const double reached = fit_to_complexity(mesh, target, limits, nullptr, field);
        EXPECT_NEAR(reached / target, 1, 1e-3);
        EXPECT_NEAR(complexity(mesh, field), reached, 1e-9 * reached);
        expect_within(limits, field);
        LogMetricField again = field;
        limit_gradation(mesh, limits.gradation, again, space);
        EXPECT_NEAR(complexity(mesh, again) / reached, 1, 0.02);  // graded, but for the last clamp
      }
}

TEST(FitToComplexity, EndsAfterATrialOnceItIsInterrupted) {
  const MeshData mesh = unit_cube(8);
  const std::atomic<bool> interrupt{true};
  const WholeDomain domain(mesh, &interrupt);
  LogMetricField field = sample(AnalyticMetric("polar-2"), mesh);
  const double reached = fit_to_complexity(domain, 5000, {0, 0, 5, 1.3, {}}, nullptr, field);
  EXPECT_GT(std::abs(reached / 5000 - 1), 0.01);
  EXPECT_NEAR(complexity(mesh, field), reached, 1e-9 * reached);
}

TEST(FitToComplexity, DoesNotScaleDemands) {
  const MeshData mesh = unit_cube(8);
  const LogMetricField demands = sample(AnalyticMetric("linear"), mesh);
  LogMetricField field = sample(AnalyticMetric("uniform:0.1"), mesh);
  const double least = complexity(mesh, demands), target = 3 * least;
  EXPECT_NEAR(fit_to_complexity(mesh, target, {0, 0, 0, 1.5, {}}, &demands, field) / target, 1, 1e-3);
  for (std::size_t v = 0; v < field.size(); ++v)
    EXPECT_TRUE(is_positive_definite(1.00001 * exp_exact(field[v]) - exp_exact(demands[v])));
}

TEST(FitToComplexity, ComesAsCloseAsLimitsAllow) {
  const MeshData mesh = unit_cube(4);
  LogMetricField field = sample(AnalyticMetric("polar-2"), mesh);
  EXPECT_NEAR(fit_to_complexity(mesh, 1e6, {0.1, 0, 2, 1.5, {}}, nullptr, field), 1000, 1e-6);
  field = sample(AnalyticMetric("polar-2"), mesh);
  EXPECT_NEAR(fit_to_complexity(mesh, 1, {0, 0.2, 2, 1.5, {}}, nullptr, field), 125, 1e-6);
}

TEST(FitToComplexity, KeepsTheDemandsAloneWhereTheyAskForMoreThanTheTarget) {
  const MeshData mesh = unit_cube(8);
  const LogMetricField demands = sample(AnalyticMetric("linear"), mesh);
  const MetricLimits limits{0, 0.3, 0, 1.3, {}};
  LogMetricField field = sample(AnalyticMetric("polar-2"), mesh), expected = demands;
  apply_limits(mesh, limits, expected);
  const double reached = fit_to_complexity(mesh, 10, limits, &demands, field);
  EXPECT_NEAR(reached / complexity(mesh, expected), 1, 1e-3);
  EXPECT_GT(reached, 100);
}

TEST(FitToComplexity, DoesNotDependOnTheThreads) {
  const MeshData mesh = unit_cube(10);
  const LogMetricField before = sample(AnalyticMetric("polar-2"), mesh);
  LogMetricField expected = before;
  fit_to_complexity(mesh, 2000, {0.01, 0.5, 20, 1.4, {}}, nullptr, expected);
  for (const int threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    LogMetricField field = before;
    fit_to_complexity(mesh, 2000, {0.01, 0.5, 20, 1.4, {}}, nullptr, field);
    EXPECT_EQ(field, expected);
  }
}

TEST(FitToComplexity, RefusesAMeshWithoutVolumeAndContradictingLimits) {
  MeshData empty;
  LogMetricField none;
  EXPECT_THROW(fit_to_complexity(empty, 100, {}, nullptr, none), InputError);
  const MeshData mesh = unit_cube(2);
  LogMetricField field = sample(AnalyticMetric("polar-2"), mesh);
  EXPECT_THROW(fit_to_complexity(mesh, -1, {}, nullptr, field), InputError);
  EXPECT_THROW(fit_to_complexity(mesh, 100, {2, 1, 0, 0, {}}, nullptr, field), InputError);
}

}  // namespace
}  // namespace weft::meshing::metric_limits_test

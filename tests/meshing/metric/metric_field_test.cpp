// Tests of reading, scaling, limiting and intersecting metric fields.
#include "meshing/metric/metric_field.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "meshing/base/error.h"
#include "meshing/metric/measures.h"
#include "tests/support/meshes.h"

namespace weft::meshing::metric_field_test {
namespace {

using support::unit_cube;

SolutionData solution_of(Field::Kind kind, std::vector<double> values) {
  const std::size_t n = values.size() / static_cast<std::size_t>(components(kind));
  return {n, {{kind, std::move(values), ""}}};
}

std::string error_of(const SolutionData& solution, std::size_t num_points) {
  try {
    metric_from_solution(solution, num_points, "m.solb");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

double size_of(const LogMetric& isotropic) { return std::exp(-0.5 * isotropic.xx); }

TEST(MetricFromSolution, ReadsSizesAndTensors) {
  const auto sizes = metric_from_solution(solution_of(Field::Kind::scalar, {1, 0.1}), 2, "m.solb");
  EXPECT_EQ(sizes[0], SymTensor{});
  EXPECT_NEAR(sizes[1].yy, std::log(100.0), 1e-14);
  EXPECT_EQ(sizes[1].xy, 0);
  const Metric m{5, 1, 6, -1, 0.5, 7};  // in the order of files: m11 m12 m22 m13 m23 m33
  const auto tensors =
      metric_from_solution(solution_of(Field::Kind::tensor, {5, 1, 6, -1, 0.5, 7}), 1, "m.solb");
  const Metric back = exp_exact(tensors[0]);
  EXPECT_NEAR(back.yy, m.yy, 1e-13);
  EXPECT_NEAR(back.xz, m.xz, 1e-13);
  EXPECT_NEAR(back.yz, m.yz, 1e-13);
}

TEST(MetricFromSolution, TakesTheFirstFieldThatCanBeAMetric) {
  SolutionData solution = solution_of(Field::Kind::vector, {1, 2, 3});
  EXPECT_EQ(error_of(solution, 1), "m.solb: holds no scalar or tensor field, so no metric");
  solution.fields.push_back({Field::Kind::scalar, {0.5}, ""});
  solution.fields.push_back({Field::Kind::scalar, {-1}, ""});
  EXPECT_NEAR(size_of(metric_from_solution(solution, 1, "m.solb")[0]), 0.5, 1e-15);
}

TEST(MetricFromSolution, RoundTripsThroughASolution) {
  const MeshData mesh = unit_cube(4);
  const auto field = sample(AnalyticMetric("polar-2"), mesh);
  const SolutionData solution = solution_from_metric(field);
  EXPECT_EQ(solution.num_points, mesh.points.size());
  const auto back = metric_from_solution(solution, mesh.points.size(), "m.solb");
  for (std::size_t i = 0; i < field.size(); ++i) {
    EXPECT_NEAR(back[i].xx, field[i].xx, 1e-9);
    EXPECT_NEAR(back[i].xy, field[i].xy, 1e-9);
    EXPECT_NEAR(back[i].zz, field[i].zz, 1e-9);
  }
}

TEST(MetricFromSolution, RefusesTheMetricOfAnotherMesh) {
  EXPECT_EQ(error_of(solution_of(Field::Kind::scalar, {1, 1}), 3),
            "m.solb: metric of another mesh: it has 2 vertices, the mesh 3");
}

TEST(MetricFromSolution, NamesTheFirstBadVertex) {
  std::vector<double> values(5000, 1.0);
  values[4000] = 0;
  values[1234] = -2;
  EXPECT_EQ(error_of(solution_of(Field::Kind::scalar, values), 5000),
            "m.solb: vertex 1235: the size is not positive (a solution is given by --sol)");
  values[17] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of(solution_of(Field::Kind::scalar, values), 5000),
            "m.solb: vertex 18: a value of the metric is not a finite number");
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error_of(solution_of(Field::Kind::tensor, {1, 0, 1, 0, inf, 1}), 1),
            "m.solb: vertex 1: a value of the metric is not a finite number");
}

TEST(MetricFromSolution, RecognisesTheRowWiseOrder) {
  // Row-wise these six have the rows (2 0.1 1.5), (0.1 3 0.2), (1.5 0.2 4); in the order of files m11 m33 <
  // m13^2.
  const std::vector<double> good = {1, 0, 1, 0, 0, 1}, row_wise = {2, 0.1, 1.5, 3, 0.2, 4};
  std::vector<double> values = row_wise;
  values.insert(values.end(), row_wise.begin(), row_wise.end());
  EXPECT_EQ(
      error_of(solution_of(Field::Kind::tensor, values), 2),
      "m.solb: vertex 1: not positive definite (it would be in row-wise order m11 m12 m13 m22 m23 m33)");
  values = good;  // row-wise this would have m22 = 0
  values.insert(values.end(), row_wise.begin(), row_wise.end());
  EXPECT_EQ(error_of(solution_of(Field::Kind::tensor, values), 2), "m.solb: vertex 2: not positive definite");
}

TEST(ScaleToComplexity, ReachesTheTarget) {
  const MeshData mesh = unit_cube(6);
  auto field = sample(AnalyticMetric("polar-2"), mesh);
  const auto before = field;
  scale_to_complexity(mesh, 12345, field);
  EXPECT_NEAR(complexity(mesh, field), 12345, 1e-8);
  EXPECT_EQ(field[7].xy, before[7].xy);
  EXPECT_NEAR(field[7].xx - before[7].xx, field[9].zz - before[9].zz, 1e-13);
}

TEST(ScaleToComplexity, ReachesTheTargetWithinLimits) {
  const MeshData mesh = unit_cube(6);
  auto field = sample(AnalyticMetric("polar-2"), mesh);
  EXPECT_NEAR(scale_to_complexity(mesh, 1000, 0.01, 0.15, field), 1000, 1);
  EXPECT_NEAR(complexity(mesh, field), 1000, 1);
  bool at_hmin = false, at_hmax = false;
  for (const LogMetric& l : field) {
    const Eigen3 e = eigen_decomposition(l);
    EXPECT_GE(e.values[0], -2 * std::log(0.15) - 1e-9);
    EXPECT_LE(e.values[2], -2 * std::log(0.01) + 1e-9);
    at_hmax |= e.values[0] < -2 * std::log(0.15) + 1e-9;
    at_hmin |= e.values[2] > -2 * std::log(0.01) - 1e-9;
  }
  EXPECT_TRUE(at_hmin || at_hmax);
}

TEST(ScaleToComplexity, WithoutLimitsIsThePlainScaling) {
  const MeshData mesh = unit_cube(4);
  auto field = sample(AnalyticMetric("polar-1"), mesh);
  auto plain = field;
  scale_to_complexity(mesh, 500, plain);
  EXPECT_NEAR(scale_to_complexity(mesh, 500, 0, 0, field), 500, 1e-6);
  for (std::size_t i = 0; i < field.size(); ++i) EXPECT_NEAR(field[i].xx, plain[i].xx, 1e-9);
}

TEST(ScaleToComplexity, ComesAsCloseAsLimitsAllow) {
  const MeshData mesh = unit_cube(4);
  auto field = sample(AnalyticMetric("polar-2"), mesh);
  EXPECT_NEAR(scale_to_complexity(mesh, 1e6, 0.1, 0, field), 1000, 1e-6);  // everywhere h = hmin
  EXPECT_NEAR(scale_to_complexity(mesh, 1, 0, 0.2, field), 125, 1e-6);     // everywhere h = hmax
}

TEST(ScaleToComplexity, RefusesAMeshWithoutVolume) {
  MeshData mesh;
  LogMetricField field;
  EXPECT_THROW(scale_to_complexity(mesh, 100, field), InputError);
  EXPECT_THROW(scale_to_complexity(mesh, 100, 0.1, 1, field), InputError);
}

TEST(LimitSizesOfField, ClampsAndLeavesTheRestAlone) {
  LogMetricField field = {log_of({1, 0, 100, 0, 0, 1e4}), log_of({25, 3, 50, 1, 2, 100})};
  const LogMetric inside = field[1];
  limit_sizes(0.02, 0.5, field);
  const Metric m = exp_exact(field[0]);
  EXPECT_NEAR(m.xx, 4, 1e-12);
  EXPECT_NEAR(m.yy, 100, 1e-10);
  EXPECT_NEAR(m.zz, 2500, 1e-9);
  EXPECT_EQ(field[1], inside);
  EXPECT_THROW(limit_sizes(2, 1, field), InputError);
}

TEST(LimitAspect, BringsTheLargestSizesDown) {
  LogMetricField field = {log_of({1, 0, 100, 0, 0, 1e6}), log_of({25, 3, 50, 1, 2, 100})};
  const LogMetric inside = field[1];
  limit_aspect(100, field);
  const Metric m = exp_exact(field[0]);
  EXPECT_NEAR(m.xx, 100, 1e-9);
  EXPECT_NEAR(m.yy, 100, 1e-9);
  EXPECT_NEAR(m.zz, 1e6, 1e-4);
  EXPECT_EQ(field[1], inside);
  limit_aspect(0, field);
  EXPECT_EQ(field[1], inside);
  limit_aspect(1, field);
  for (const LogMetric& l : field) EXPECT_NEAR(squared_length(l, {0.6, 0.8, 0}), l.zz, 1e-12);
}

TEST(IntersectWith, IsAsFineAsBoth) {
  const MeshData mesh = unit_cube(5);
  const LogMetricField a = sample(AnalyticMetric("polar-2"), mesh),
                       b = sample(AnalyticMetric("linear"), mesh);
  LogMetricField both = a;
  intersect_with(b, both);
  for (std::size_t v = 0; v < both.size(); ++v)
    for (const LogMetric& one : {a[v], b[v]})
      EXPECT_TRUE(is_positive_definite(1.000001 * exp_exact(both[v]) - exp_exact(one)));
}

}  // namespace
}  // namespace weft::meshing::metric_field_test

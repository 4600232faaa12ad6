// Tests of multiscale metrics.
#include "meshing/metric/sources/multiscale.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_limits.h"
#include "tests/support/case_files.h"
#include "tests/support/meshes.h"

namespace weft::meshing::multiscale_test {
namespace {

using support::unit_cube;

constexpr HessianRecovery kRecoveries[] = {HessianRecovery::least_squares,
                                           HessianRecovery::double_projection};

MeshData jittered_cube(std::uint32_t n) {
  MeshData mesh = unit_cube(n);
  support::jitter_interior(mesh, 0.2 / n);
  return mesh;
}

template <class F>
std::vector<double> values_of(const MeshData& mesh, const F& f) {
  std::vector<double> values;
  for (const Point& p : mesh.points) values.push_back(f(p));
  return values;
}

double largest_difference(const SymTensor& a, const SymTensor& b) {
  const Eigen3 e = eigen_decomposition(a - b);
  return std::max(std::abs(e.values[0]), std::abs(e.values[2]));
}

TEST(Multiscale, IsTheFormulaForAQuadratic) {
  const MeshData mesh = jittered_cube(5);
  const auto values =
      values_of(mesh, [](const Point& p) { return 4 * p.x * p.x - p.y * p.y + 0.1 * p.z * p.z; });
  // Hessian diag(8, -2, 0.2) over the largest value, 4.1.
  const double scale = 1 / 4.1, det = 8 * 2 * 0.2 * scale * scale * scale;
  for (const double norm : {1.0, 2.0, 4.0, std::numeric_limits<double>::infinity()}) {
    const double factor = std::pow(det, -1 / (2 * norm + 3)) * scale;
    const LogMetric exact = log_of({8 * factor, 0, 2 * factor, 0, 0, 0.2 * factor});
    for (const LogMetric& l : multiscale_metric(mesh, values, {HessianRecovery::least_squares, norm}))
      EXPECT_LT(largest_difference(l, exact), 1e-9);
  }
}

TEST(Multiscale, DoesNotDependOnTheUnitsOfTheField) {
  const MeshData mesh = jittered_cube(6);
  const auto f = [](const Point& p) { return std::tanh(10 * (p.x - 0.4)) + p.y * p.z; };
  auto expected = multiscale_metric(mesh, values_of(mesh, f), {});
  scale_to_complexity(mesh, 1000, expected);
  for (const double unit : {1e-300, 1e-20, -7.0, 1e20, 1e300}) {
    auto field = multiscale_metric(mesh, values_of(mesh, [&](const Point& p) { return unit * f(p); }), {});
    scale_to_complexity(mesh, 1000, field);
    for (std::size_t v = 0; v < field.size(); ++v) EXPECT_LT(largest_difference(field[v], expected[v]), 1e-7);
  }
}

TEST(Multiscale, IsPositiveDefiniteForAnyFiniteField) {
  const MeshData mesh = jittered_cube(6);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-1, 1);
  constexpr double kHuge = std::numeric_limits<double>::max(),
                   kTiny = std::numeric_limits<double>::denorm_min();
  std::size_t count = 0;
  const std::vector<std::vector<double>> fields = {
      values_of(mesh, [](const Point&) { return 0.0; }),
      values_of(mesh, [](const Point&) { return -1e5; }),
      values_of(mesh, [](const Point& p) { return 3 * p.x - p.z; }),
      values_of(mesh, [&](const Point&) { return noise(random); }),
      values_of(mesh, [&](const Point&) { return 1e5 + 1e-11 * noise(random); }),
      values_of(mesh, [&](const Point&) { return kHuge * noise(random); }),
      values_of(mesh, [&](const Point&) { return noise(random) > 0 ? kHuge : -kHuge; }),
      values_of(mesh, [&](const Point&) { return noise(random) > 0 ? kTiny : 0; }),
      values_of(mesh, [&](const Point&) { return count++ == 100 ? 1e200 : 0; }),
      values_of(mesh, [](const Point& p) { return p.x > 0.5 ? 1.0 : 0.0; }),
      values_of(mesh, [](const Point& p) { return p.x * p.x; }),
  };
  for (const auto& values : fields)
    for (const HessianRecovery recovery : kRecoveries) {
      auto field = multiscale_metric(mesh, values, {recovery, 2});
      EXPECT_NEAR(fit_to_complexity(mesh, 500, {0, 0, 0, 1.5, {}}, nullptr, field), 500, 0.5);
      for (const LogMetric& l : field) ASSERT_TRUE(is_positive_definite(exp_exact(l)));
    }
}

TEST(Multiscale, ResolvesAShockAcrossIt) {
  const MeshData mesh = jittered_cube(10);
  const auto values = values_of(mesh, [](const Point& p) { return std::tanh(8 * (p.x - 0.5)); });
  for (const HessianRecovery recovery : kRecoveries) {
    auto field = multiscale_metric(mesh, values, {recovery, 2});
    fit_to_complexity(mesh, 2000, {0, 0, 0, 1.5, {}}, nullptr, field);
    for (std::size_t v = 0; v < field.size(); ++v) {
      const double from_middle = std::abs(mesh.points[v].x - 0.5);  // the field's point of inflection
      if (from_middle < 0.05 || from_middle > 0.2) continue;
      EXPECT_GT(std::abs(eigen_decomposition(field[v]).vectors[2].x), 0.9);
    }
  }
}

TEST(Multiscale, RefusesWhatIsNotFinite) {
  const MeshData mesh = unit_cube(2);
  auto values = values_of(mesh, [](const Point& p) { return p.x; });
  EXPECT_THROW(multiscale_metric(mesh, values, {HessianRecovery::least_squares, 0.5}), InputError);
  values[4] = std::numeric_limits<double>::infinity();
  try {
    multiscale_metric(mesh, values, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "vertex 5: the value is not a finite number");
  }
}

TEST(ScalarFields, TakesScalarsAndNamesWhatIsWrong) {
  SolutionData solution{2, {{Field::Kind::vector, {1, 2, 3, 4, 5, 6}, ""}}};
  const auto error_of = [&](std::size_t num_points) -> std::string {
    try {
      scalar_fields(solution, num_points, "s.solb");
      return "no error";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(error_of(2), "s.solb: holds no scalar field to take a metric from");
  EXPECT_EQ(error_of(3), "s.solb: solution of another mesh: it has 2 vertices, the mesh 3");
  solution.fields.push_back({Field::Kind::scalar, {7, 8}, ""});
  solution.fields.push_back({Field::Kind::scalar, {9, 10}, ""});
  ASSERT_EQ(scalar_fields(solution, 2, "s.solb").size(), 2);
  EXPECT_EQ(scalar_fields(solution, 2, "s.solb")[1][0], 9);
  solution.fields[2].values[1] = std::nan("");
  EXPECT_EQ(error_of(2), "s.solb: vertex 2: the value of field 3 is not a finite number");
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(MultiscaleCases, AgreesWithRefineOnTheDeltaWing) {
  const std::filesystem::path folder = support::case_files() / "delta-wing";
  if (!std::filesystem::exists(folder / "start-mach.solb"))
    GTEST_SKIP() << "NOT TESTED: the case files are not at " << folder << " (set WEFT_CASES to their folder)";
  const MeshData mesh = read_mesh(folder / "start.meshb");
  const SolutionData mach = read_solution(folder / "start-mach.solb");
  const std::size_t n = mesh.points.size();
  const auto theirs =
      metric_from_solution(read_solution(folder / "start-metric.solb"), n, "start-metric.solb");
  for (const HessianRecovery recovery : kRecoveries) {
    auto ours = multiscale_metric(mesh, scalar_fields(mach, n, "start-mach.solb")[0], {recovery, 2});
    EXPECT_NEAR(fit_to_complexity(mesh, 50000, {0, 0, 0, 1.5, {}}, nullptr, ours) / 50000, 1, 1e-3);
    EXPECT_NEAR(complexity(mesh, ours) / complexity(mesh, theirs), 1, 0.01);
    // The largest difference of ln h in any direction: 1/2 the spectral norm of the difference of logarithms.
    std::vector<double> differences;
    for (std::size_t v = 0; v < n; ++v) differences.push_back(0.5 * largest_difference(ours[v], theirs[v]));
    EXPECT_LT(median(differences), 0.15);
  }
}

}  // namespace
}  // namespace weft::meshing::multiscale_test

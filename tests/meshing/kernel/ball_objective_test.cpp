// Tests of what smoothing minimises: derivatives against finite differences, values against the judge.
#include "meshing/kernel/ball_objective.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::ball_objective_test {
namespace {

using support::KernelRig;

/// A random log-metric with sizes between e^-spread and e^spread in random directions.
LogMetric random_log_metric(std::mt19937& random, double spread) {
  std::uniform_real_distribution<double> value(-2 * spread, 2 * spread), part(-1, 1);
  const double x = part(random), y = part(random), z = part(random), w = part(random);
  Vec a{x, y, z};
  a = (1 / norm(a)) * a;
  Vec b = cross(a, {y, z, w});
  b = (1 / norm(b)) * b;
  const double v0 = value(random), v1 = value(random), v2 = value(random);
  return from_eigen({{v0, v1, v2}, {a, b, cross(a, b)}});
}

std::unique_ptr<KernelRig> random_octahedron(unsigned seed, MetricMean mean) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  MeshData mesh = support::octahedron();
  for (Point& p : mesh.points) {
    const double x = shift(random), y = shift(random), z = shift(random);
    p += Point{x, y, z};
  }
  LogMetricField field;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) field.push_back(random_log_metric(random, 0.5));
  auto rig = std::make_unique<KernelRig>(mesh, field);
  rig->judge_by(mean);
  return rig;
}

class BallObjective : public testing::TestWithParam<MetricMean> {};

TEST_P(BallObjective, DerivativesAreThoseOfFiniteDifferences) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto made = random_octahedron(seed, GetParam());
    KernelRig& rig = *made;
    ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), rig.worker.ball), Verdict::accepted);
    BallFaces faces;
    faces.gather(rig.kernel.policy.mean, rig.mesh, rig.worker.ball);
    ASSERT_EQ(faces.size(), 8);
    const Point x = rig.mesh.point(VertexId(0));
    const SymTensor m = judge_tensor(rig.kernel.policy.mean, rig.mesh, VertexId(0));
    const auto at = [&](const Vec& d) { return faces.derivatives(x + d, m); };
    const BallDerivatives d = at({});
    constexpr double kStep = 1e-5;
    const double scale = norm(d.gradient) + trace(d.hessian);
    for (int i = 0; i < 3; ++i) {
      Vec step;
      step[i] = kStep;
      const BallDerivatives plus = at(step), minus = at(-1.0 * step);
      EXPECT_NEAR(d.gradient[i], (plus.value - minus.value) / (2 * kStep), 1e-6 * scale);
      const Vec row = (0.5 / kStep) * (plus.gradient - minus.gradient);
      const SymTensor& h = d.hessian;
      const Vec expected[3] = {{h.xx, h.xy, h.xz}, {h.xy, h.yy, h.yz}, {h.xz, h.yz, h.zz}};
      EXPECT_LT(norm(row - expected[i]), 1e-6 * scale) << "row " << i << ", seed " << seed;
    }
  }
}

TEST_P(BallObjective, ValueIsTheSumOfInverseQualities) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto made = random_octahedron(seed, GetParam());
    KernelRig& rig = *made;
    ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), rig.worker.ball), Verdict::accepted);
    BallFaces faces;
    faces.gather(rig.kernel.policy.mean, rig.mesh, rig.worker.ball);
    const SymTensor m = judge_tensor(rig.kernel.policy.mean, rig.mesh, VertexId(0));
    double sum = 0, least = 1;
    for (const auto& [t, local] : rig.worker.ball.tets) {
      sum += 1 / static_cast<double>(rig.mesh.quality(t));
      least = std::min<double>(least, rig.mesh.quality(t));
    }
    EXPECT_NEAR(faces.derivatives(rig.mesh.point(VertexId(0)), m).value, sum, 1e-5 * sum);
    std::vector<float> qualities;
    EXPECT_NEAR(faces.qualities(rig.mesh.point(VertexId(0)), m, qualities), least, 1e-5);
    ASSERT_EQ(qualities.size(), rig.worker.ball.tets.size());
    for (std::size_t i = 0; i < qualities.size(); ++i)
      EXPECT_NEAR(qualities[i], rig.mesh.quality(rig.worker.ball.tets[i].tet), 1e-5);
  }
}

TEST_P(BallObjective, QualitiesAreRefusedWhereATetIsNotExactlyPositive) {
  KernelRig rig(support::octahedron());
  rig.judge_by(GetParam());
  ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), rig.worker.ball), Verdict::accepted);
  BallFaces faces;
  faces.gather(rig.kernel.policy.mean, rig.mesh, rig.worker.ball);
  const SymTensor m = judge_tensor(rig.kernel.policy.mean, rig.mesh, VertexId(0));
  std::vector<float> qualities;
  EXPECT_GT(faces.qualities({0.3, 0.3, 0.3}, m, qualities), 0);
  EXPECT_EQ(faces.qualities({0.5, 0.5, 0}, m, qualities), -1) << "in the plane of a face";
  EXPECT_EQ(faces.qualities({0.5, 0.5, 0.5}, m, qualities), -1);
}

TEST_P(BallObjective, EachFaceGivesItsOwnValueAndGradient) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const auto made = random_octahedron(seed, GetParam());
    KernelRig& rig = *made;
    ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), rig.worker.ball), Verdict::accepted);
    BallFaces faces;
    faces.gather(rig.kernel.policy.mean, rig.mesh, rig.worker.ball);
    const BallDerivatives d = faces.derivatives(rig.mesh.point(VertexId(0)),
                                                judge_tensor(rig.kernel.policy.mean, rig.mesh, VertexId(0)));
    double value = 0;
    Vec gradient;
    for (int k = 0; k < faces.size(); ++k) {
      EXPECT_NEAR(faces.value(k) * static_cast<double>(rig.mesh.quality(rig.worker.ball.tets[k].tet)), 1,
                  1e-5);
      value += faces.value(k);
      gradient += faces.gradient(k);
    }
    EXPECT_NEAR(value, d.value, 1e-12 * d.value);
    EXPECT_LT(norm(gradient - d.gradient), 1e-11 * d.value);
  }
}

TEST_P(BallObjective, ServesBallsOfAnySize) {
  // Groups of eight faces, full or not.
  for (std::uint32_t n = 3; n <= 20; ++n) {
    MeshData mesh = support::ring_of(n, 1);
    KernelRig rig(mesh);
    rig.judge_by(GetParam());
    for (const VertexId v : rig.live_vertices()) {
      ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, v, rig.worker.ball), Verdict::accepted);
      BallFaces& faces = rig.worker.faces;  // as the operators use it: once large, then small
      faces.gather(rig.kernel.policy.mean, rig.mesh, rig.worker.ball);
      double sum = 0;
      for (const auto& [t, local] : rig.worker.ball.tets) sum += 1 / static_cast<double>(rig.mesh.quality(t));
      EXPECT_NEAR(
          faces.derivatives(rig.mesh.point(v), judge_tensor(rig.kernel.policy.mean, rig.mesh, v)).value, sum,
          1e-5 * sum);
      std::vector<float> qualities;
      faces.qualities(rig.mesh.point(v), judge_tensor(rig.kernel.policy.mean, rig.mesh, v), qualities);
      ASSERT_EQ(qualities.size(), rig.worker.ball.tets.size());
      for (std::size_t i = 0; i < qualities.size(); ++i)
        EXPECT_NEAR(qualities[i], rig.mesh.quality(rig.worker.ball.tets[i].tet), 1e-5);
      rig.worker.claims.release();
    }
  }
}

/// BallFaces gives the octahedron in metrics of this size the qualities that the judge gives it.
void expect_qualities_of_the_judge(double size, MetricMean mean) {
  KernelRig rig(support::octahedron({0.1, 0.2, -0.1}), size);
  rig.judge_by(mean);
  ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), rig.worker.ball), Verdict::accepted);
  BallFaces faces;
  faces.gather(rig.kernel.policy.mean, rig.mesh, rig.worker.ball);
  const SymTensor m = judge_tensor(rig.kernel.policy.mean, rig.mesh, VertexId(0));
  std::vector<float> qualities;
  faces.qualities(rig.mesh.point(VertexId(0)), m, qualities);
  ASSERT_EQ(qualities.size(), rig.worker.ball.tets.size());
  double sum = 0, largest_error = 0;
  for (std::size_t i = 0; i < qualities.size(); ++i) {
    const double judged = rig.mesh.quality(rig.worker.ball.tets[i].tet);
    largest_error = std::max(largest_error, std::abs(qualities[i] - judged));
    sum += 1 / judged;
  }
  EXPECT_LT(largest_error, 1e-5) << "size " << size;
  const double value = faces.derivatives(rig.mesh.point(VertexId(0)), m).value;
  EXPECT_NEAR(value, sum, 1e-5 * sum) << "size " << size;
}

TEST_P(BallObjective, DoesNotDependOnTheScaleOfTheMetric) {
  for (const double size : {1e-5, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e5})
    expect_qualities_of_the_judge(size, GetParam());
}

// A tet's volume in the metric squared leaves the range of single precision, in which cube_root starts.
TEST_P(BallObjective, DoesNotDependOnTheScaleOfTheMetricHoweverExtreme) {
  for (const double size : {1e-12, 1e-9, 1e6, 1e9, 1e12}) expect_qualities_of_the_judge(size, GetParam());
}

INSTANTIATE_TEST_SUITE_P(, BallObjective, testing::Values(MetricMean::arithmetic, MetricMean::log_euclidean),
                         [](const auto& param_info) {
                           return param_info.param == MetricMean::arithmetic ? "arithmetic" : "log_euclidean";
                         });

}  // namespace
}  // namespace weft::meshing::ball_objective_test

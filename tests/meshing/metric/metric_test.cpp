// Tests of the metric: logarithm and exponential, lengths, limits, intersection, analytic metrics.
#include "meshing/metric/metric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

#include "meshing/base/error.h"

namespace weft::meshing::metric_test {
namespace {

double max_entry(const SymTensor& a) {
  return std::max(
      {std::abs(a.xx), std::abs(a.xy), std::abs(a.yy), std::abs(a.xz), std::abs(a.yz), std::abs(a.zz)});
}

::testing::AssertionResult near(const SymTensor& a, const SymTensor& b, double relative) {
  const double difference = max_entry(a - b) / max_entry(b);
  if (difference <= relative) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "relative difference " << difference;
}

/// Tensors with given eigenvalues in random frames.
class RandomTensors {
 public:
  explicit RandomTensors(unsigned seed) : random_(seed) {}
  SymTensor operator()(double a, double b, double c) {
    const Vec u = unit(), w = unit();
    Vec v = w - dot(u, w) * u;
    v = (1 / norm(v)) * v;
    return from_eigen({{a, b, c}, {u, v, cross(u, v)}});
  }
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  Vec unit() {
    std::normal_distribution<double> normal;
    const Vec v{normal(random_), normal(random_), normal(random_)};
    return (1 / norm(v)) * v;
  }

 private:
  std::mt19937 random_;
};

TEST(EigenDecomposition, FindsAscendingValuesAndTheirVectors) {
  RandomTensors tensor(1);
  for (int i = 0; i < 100; ++i) {
    const SymTensor a = tensor(3, -1, 20);
    const Eigen3 e = eigen_decomposition(a);
    EXPECT_NEAR(e.values[0], -1, 1e-13);
    EXPECT_NEAR(e.values[1], 3, 1e-13);
    EXPECT_NEAR(e.values[2], 20, 1e-13);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(norm(apply(a, e.vectors[k]) - e.values[k] * e.vectors[k]), 0, 1e-13);
    EXPECT_TRUE(near(from_eigen(e), a, 1e-14));
  }
}

TEST(EigenDecomposition, SurvivesHugeAndTinyEntries) {
  for (const double scale : {1e-200, 1e200}) {
    const Eigen3 e = eigen_decomposition(scale * SymTensor{2, 1, 2, 0, 0, 5});
    EXPECT_NEAR(e.values[0] / scale, 1, 1e-14);
    EXPECT_NEAR(e.values[1] / scale, 3, 1e-14);
    EXPECT_NEAR(e.values[2] / scale, 5, 1e-14);
  }
}

TEST(PositiveDefinite, TellsMetricsFromOthers) {
  RandomTensors tensor(2);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_positive_definite(identity_tensor(1e-30)));
  EXPECT_TRUE(is_positive_definite(identity_tensor(1e30)));
  EXPECT_FALSE(is_positive_definite(SymTensor{}));
  EXPECT_FALSE(is_positive_definite({1, 0, 1, 0, 0, nan}));
  EXPECT_FALSE(is_positive_definite({1, nan, 1, 0, 0, 1}));
  EXPECT_FALSE(is_positive_definite({1, 0, inf, 0, 0, 1}));
  EXPECT_FALSE(is_positive_definite({1, 2, 1, 0, 0, 1}));  // the leading minors are 1, -3, -3
  EXPECT_FALSE(
      is_positive_definite({-1, 0, -1, 0, 0, 1}));  // two negative values make the determinant positive
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(is_positive_definite(tensor(1, 1e5, 1e10)));
    EXPECT_FALSE(is_positive_definite(tensor(-1, 1e5, 1e10)));
  }
}

TEST(LogExp, IsKnownForDiagonalMetrics) {
  const double e = std::numbers::e;
  EXPECT_TRUE(near(log_of({e, 0, e * e, 0, 0, 1 / e}), {1, 0, 2, 0, 0, -1}, 1e-15));
  EXPECT_TRUE(near(exp_exact({1, 0, 2, 0, 0, -1}), {e, 0, e * e, 0, 0, 1 / e}, 1e-15));
  EXPECT_TRUE(near(exp_fast({1, 0, 2, 0, 0, -1}), {e, 0, e * e, 0, 0, 1 / e}, 1e-14));
}

TEST(LogExp, RoundTripsUpToAnisotropy100000) {
  RandomTensors tensor(3);
  for (const double ratio : {1.0, 10.0, 1e3, 1e5})  // of sizes; of eigenvalues its square
    for (int i = 0; i < 200; ++i) {
      const Metric m = tensor(1, std::pow(ratio, tensor.uniform(0, 2)), ratio * ratio);
      EXPECT_TRUE(near(exp_exact(log_of(m)), m, 1e-12)) << ratio;
      EXPECT_TRUE(near(exp_fast(log_of(m)), m, 1e-12)) << ratio;
      const SymTensor l = tensor(0, std::log(ratio), 2 * std::log(ratio));
      // The smallest eigenvalue is lost by as much as rounding of the largest.
      EXPECT_NEAR(max_entry(log_of(exp_exact(l)) - l), 0, 1e-14 * ratio * ratio + 1e-13) << ratio;
    }
}

TEST(LogExp, RoundTripsRepeatedEigenvalues) {
  RandomTensors tensor(4);
  for (int i = 0; i < 200; ++i)
    for (const Metric& m : {tensor(100, 100, 1e6), tensor(100, 1e6, 1e6), tensor(50, 50, 50),
                            tensor(100, 100 * (1 + 1e-9), 1e4), tensor(100, 100 * (1 + 1e-13), 100)}) {
      EXPECT_TRUE(near(exp_exact(log_of(m)), m, 1e-13));
      EXPECT_TRUE(near(exp_fast(log_of(m)), m, 1e-13));
    }
}

TEST(LogExp, ExpFastEqualsExpExact) {
  RandomTensors tensor(5);
  for (int i = 0; i < 20000; ++i) {
    const double spread = std::pow(10, tensor.uniform(-9, 1.6)), mean = tensor.uniform(-10, 30);
    const LogMetric l = tensor(mean + tensor.uniform(-spread, spread), mean + tensor.uniform(-spread, spread),
                               mean + tensor.uniform(-spread, spread));
    const Eigen3 e = eigen_decomposition(l);
    EXPECT_TRUE(near(exp_fast(l), exp_exact(l), 1e-12)) << "spread " << e.values[2] - e.values[0];
  }
}

TEST(LogExp, ExpFastKeepsTheSmallEigenvalue) {
  RandomTensors tensor(6);
  for (int i = 0; i < 1000; ++i) {
    const Vec u = tensor.unit(), w = tensor.unit();
    Vec v = w - dot(u, w) * u;
    v = (1 / norm(v)) * v;
    for (const std::array<double, 3>& logs :
         {std::array{0.0, 5.0, 16.0}, {0, 3, 11}, {0, 11, 11}, {0, 0, 12}}) {
      const Metric m = exp_fast(from_eigen({logs, {u, v, cross(u, v)}}));
      EXPECT_NEAR(squared_length(m, u), 1, 1e-13 * std::exp(logs[2])) << logs[2];
    }
  }
}

TEST(EdgeLength, IsTheIntegralOverAGeometricSize) {
  // h grows from 1 to e along the unit edge: length = integral of e^-t = 1 - 1/e.
  const double e = std::numbers::e;
  EXPECT_NEAR(edge_length({1, 0, 0}, identity_tensor(), identity_tensor(1 / (e * e))), 1 - 1 / e, 1e-15);
  EXPECT_DOUBLE_EQ(edge_length({0, 2, 0}, identity_tensor(9), identity_tensor(9)), 6);
  EXPECT_DOUBLE_EQ(log_mean_length(1.0005, 1), 1.00025);
  EXPECT_DOUBLE_EQ(edge_length({1, 2, 3}, {1, 0, 4, 0, 0, 9}, {1, 0, 4, 0, 0, 9}), std::sqrt(1 + 16 + 81));
}

TEST(EdgeLength, FastFormIsWithinItsBound) {
  for (double ratio = 1; ratio <= 4; ratio += 0.01) {
    const Metric a = identity_tensor(), b = identity_tensor(ratio * ratio);
    EXPECT_NEAR(edge_length_fast({1, 0, 0}, a, b) / edge_length({1, 0, 0}, a, b), 1, 2e-3) << ratio;
  }
}

TEST(LimitSizes, ClampsTheSizes) {
  RandomTensors tensor(7);
  for (int i = 0; i < 100; ++i) {
    const Metric m = tensor(1, 100, 1e4);  // sizes 1, 0.1, 0.01
    const Eigen3 e = eigen_decomposition(limit_sizes(m, 0.02, 0.5));
    EXPECT_NEAR(e.values[0], 4, 1e-9);
    EXPECT_NEAR(e.values[1], 100, 1e-9);
    EXPECT_NEAR(e.values[2], 2500, 1e-9);
    EXPECT_TRUE(near(limit_sizes(m, 0, 0), m, 1e-14));
    EXPECT_TRUE(near(limit_sizes(m, 0.001, 2), m, 1e-14));
  }
}

TEST(Intersect, IsTheFinerOfAlignedMetrics) {
  EXPECT_TRUE(near(intersect({1, 0, 100, 0, 0, 7}, {4, 0, 25, 0, 0, 7}), {4, 0, 100, 0, 0, 7}, 1e-14));
}

TEST(Intersect, TakesTheFinerInEveryCommonConjugateDirection) {
  RandomTensors tensor(9);
  for (int i = 0; i < 200; ++i) {
    // Rows that are not orthogonal: sums of c (row)(row) share these directions, and the intersection has
    // max(c).
    const std::array<Vec, 3> rows = {tensor.unit(), tensor.unit(), tensor.unit()};
    if (std::abs(dot(cross(rows[0], rows[1]), rows[2])) < 0.1) continue;
    const auto combine = [&rows](std::array<double, 3> c) {
      SymTensor sum;
      for (int k = 0; k < 3; ++k) {
        const Vec& r = rows[k];
        sum = sum + c[k] * SymTensor{r.x * r.x, r.x * r.y, r.y * r.y, r.x * r.z, r.y * r.z, r.z * r.z};
      }
      return sum;
    };
    EXPECT_TRUE(near(intersect(combine({1, 50, 300}), combine({20, 5, 2})), combine({20, 50, 300}), 1e-11));
  }
}

TEST(Intersect, IsAccurateWhereWeakSizesNearlyCoincide) {
  RandomTensors tensor(11);
  for (int i = 0; i < 100; ++i)
    for (const double strong : {2.0, 1e3, 1e8}) {
      const Vec v = tensor.unit();
      Vec w = cross(v, tensor.unit());
      w = (1 / norm(w)) * w;
      const Eigen3 e{{0.5, 0.5 + 1e-9, strong}, {w, cross(v, w), v}};
      const Metric both = intersect(identity_tensor(), from_eigen(e));
      EXPECT_NEAR(squared_length(both, w), 1, 1e-7);
      EXPECT_NEAR(squared_length(both, cross(v, w)), 1, 1e-7);
      EXPECT_NEAR(squared_length(both, v) / strong, 1, 1e-12);
    }
}

TEST(Intersect, IsAtLeastAsFineAsBoth) {
  RandomTensors tensor(8);
  for (int i = 0; i < 200; ++i) {
    const Metric a = tensor(1, tensor.uniform(1, 1e4), 1e4), b = tensor(2, tensor.uniform(2, 1e4), 1e4);
    const Metric both = intersect(a, b);
    EXPECT_TRUE(near(intersect(b, a), both, 1e-10));
    EXPECT_TRUE(near(intersect(both, a), both, 1e-10));
    for (int k = 0; k < 20; ++k) {
      const Vec v = tensor.unit();
      EXPECT_GE(squared_length(both, v) * (1 + 1e-10), std::max(squared_length(a, v), squared_length(b, v)));
    }
  }
  const Metric a = tensor(1, 10, 100);
  EXPECT_TRUE(near(intersect(a, a), a, 1e-13));
  EXPECT_TRUE(near(intersect(a, 0.5 * a), a, 1e-13));
  EXPECT_TRUE(near(intersect(0.5 * a, a), a, 1e-13));
}

TEST(AnalyticMetric, Polar2HasItsPublishedValues) {
  const AnalyticMetric polar2("polar-2");
  // On the layer, at angle 0: h_r = 0.001, h_t = 0.025, h_z = 0.1.
  EXPECT_TRUE(near(polar2({0.5, 0, 0.3}), {1e6, 0, 1600, 0, 0, 100}, 1e-14));
  // At angle 90 degrees the axes are exchanged.
  EXPECT_TRUE(near(polar2({0, 0.5, 0.3}), {1600, 0, 1e6, 0, 0, 100}, 1e-14));
  // r = 0.55: d = 0.5, h_t = 0.0625, h_r = 0.001 + 2 * 0.099 * 0.05 = 0.0109; at 45 degrees.
  const double r = 0.55 / std::numbers::sqrt2, mr = 1 / (0.0109 * 0.0109), mt = 256;
  EXPECT_TRUE(near(polar2({r, r, 0}), {(mr + mt) / 2, (mr - mt) / 2, (mr + mt) / 2, 0, 0, 100}, 1e-12));
  // r = 0.45 likewise, the layer being symmetric.
  const double s = 0.45 / std::numbers::sqrt2;
  EXPECT_TRUE(near(polar2({s, s, 0}), polar2({r, r, 0}), 1e-12));
  // Far from the layer: h_r = 0.001 + 2 * 0.099 * 0.5 = 0.1, h_t = 0.1.
  EXPECT_TRUE(near(polar2({1, 0, 0}), identity_tensor(100), 1e-12));
  EXPECT_TRUE(near(polar2({0, 0, 0}), identity_tensor(100), 1e-12));
}

TEST(AnalyticMetric, TheOthersHaveTheirFormulas) {
  EXPECT_TRUE(near(AnalyticMetric("polar-1")({0.5, 0, 0}), {1e6, 0, 100, 0, 0, 100}, 1e-14));
  EXPECT_TRUE(near(AnalyticMetric("linear")({0.3, 0.9, 0.5}), {100, 0, 100, 0, 0, 1e6}, 1e-14));
  EXPECT_TRUE(near(AnalyticMetric("linear")({0.3, 0.9, 1}), identity_tensor(100), 1e-12));
  EXPECT_TRUE(near(AnalyticMetric("uniform:0.25")({1, 2, 3}), identity_tensor(16), 1e-15));
}

TEST(AnalyticMetric, RefusesWhatItDoesNotKnow) {
  for (const char* name : {"", "polar", "polar-3", "uniform", "uniform:", "uniform:0", "uniform:-1",
                           "uniform:x", "uniform:1x", "uniform:inf", "uniform:nan"})
    EXPECT_THROW(AnalyticMetric{name}, InputError) << name;
}

TEST(Metric, TheDeterminantOfADefiniteTensorIsRightAtStrongAnisotropy) {
  const Vec n = (1 / std::sqrt(14.0)) * Vec{1, 2, 3};
  for (const double ratio : {1.0, 1e3, 1e5, 1e6}) {
    const double more = ratio * ratio - 1;
    const Metric thin = {1 + more * n.x * n.x, more * n.x * n.y, 1 + more * n.y * n.y,
                         more * n.x * n.z,     more * n.y * n.z, 1 + more * n.z * n.z};
    EXPECT_NEAR(determinant_of_definite(thin) / (ratio * ratio), 1, 1e-15 + 1e-15 * ratio * ratio);
  }
  EXPECT_FALSE(determinant_of_definite(SymTensor{}) > 0);
  EXPECT_FALSE(determinant_of_definite(SymTensor{1, 2, 1, 0, 0, 1}) > 0);
}

}  // namespace
}  // namespace weft::meshing::metric_test

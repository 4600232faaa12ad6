// Areas and cuts in a metric against what they are by definition.
#include "partition/decompose/tet_measures.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>
#include <utility>

#include "meshing/mesh/tet_tables.h"

namespace weft::partition::tet_measures_test {
namespace {

using meshing::LogMetric;
using meshing::Point;
using meshing::SymTensor;
using meshing::Vec;

constexpr TetCorners kRegular{Point{1, 1, 1}, Point{1, -1, -1}, Point{-1, 1, -1}, Point{-1, -1, 1}};

Vec random_vec(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {unit(random), unit(random), unit(random)};
}

LogMetric random_log_metric(std::mt19937& random) {
  const Vec a = random_vec(random), b = random_vec(random);
  return {3 * a.x, a.y, 3 * a.z, b.x, b.y, 3 * b.z};
}

void expect_proportional(const SymTensor& a, const SymTensor& b) {
  const double factor = trace(a) / trace(b);
  const SymTensor difference = a - factor * b;
  EXPECT_LT(std::sqrt(squared_length(difference, {1, 2, -1}) * squared_length(difference, {1, 2, -1})),
            1e-9 * trace(a));
  for (const Vec& v : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}, Vec{1, 1, 0}, Vec{1, 0, 1}, Vec{0, 1, 1}})
    EXPECT_NEAR(squared_length(difference, v), 0, 1e-9 * trace(a));
}

TEST(TetMeasures, FaceAreasAreThoseOfTheMetric) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const TetCorners tet{random_vec(random), random_vec(random), random_vec(random), random_vec(random)};
    const LogMetric log_metric = random_log_metric(random);
    const SymTensor m = meshing::exp_exact(log_metric);
    const std::array<float, 4> areas =
        face_areas(tet, unit_inverse(log_metric), std::exp(trace(log_metric) / 3));
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& face = meshing::kTetFaces[f];
      const Vec u = tet[face[1]] - tet[face[0]], v = tet[face[2]] - tet[face[0]];
      const double uv = dot(u, apply(m, v));
      const double area = 0.5 * std::sqrt(squared_length(m, u) * squared_length(m, v) - uv * uv);
      EXPECT_NEAR(areas[f], area, 1e-5 * area);
    }
  }
}

TEST(TetMeasures, CutsThroughATetThatSuitsTheMetricCostWhatThePlaneCosts) {
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const LogMetric log_metric = random_log_metric(random);
    const SymTensor to_physical =
        meshing::exp_exact(-0.5 * log_metric);  // a regular tet becomes one in the metric
    TetCorners tet = kRegular;
    for (Point& p : tet) p = apply(to_physical, p) + Point{7, 8, 9};
    expect_proportional(cut_tensor(tet, unit_inverse(log_metric)), unit_inverse(log_metric));
  }
}

TEST(TetMeasures, CutsThroughARegularTetAreLessThanTwiceAsDearInTheWorstDirection) {
  const LogMetric thin{0, 0, 0, 0, 0, std::log(1e4)};  // sizes 1, 1, 0.01
  const SymTensor t = cut_tensor(kRegular, unit_inverse(thin));
  const double across_thin = squared_length(t, {0, 0, 1}), along = squared_length(t, {1, 0, 0});
  EXPECT_GT(along, across_thin);
  EXPECT_LT(along, 2 * across_thin);
  EXPECT_GT(squared_length(unit_inverse(thin), {1, 0, 0}),
            9999 * squared_length(unit_inverse(thin), {0, 0, 1}));
}

/// The mean at the centres of the 8^`levels` tets that halving edges makes.
double sampled_mean_of_exp(const std::array<double, 4>& x, int levels) {
  if (levels == 0) return std::exp(0.25 * (x[0] + x[1] + x[2] + x[3]));
  const auto mid = [&](int i, int j) { return 0.5 * (x[i] + x[j]); };
  const double a = mid(0, 1), b = mid(0, 2), c = mid(0, 3), d = mid(1, 2), e = mid(1, 3), f = mid(2, 3);
  double sum = 0;
  for (const std::array<double, 4>& part :
       std::initializer_list<std::array<double, 4>>{{x[0], a, b, c},
                                                    {a, x[1], d, e},
                                                    {b, d, x[2], f},
                                                    {c, e, f, x[3]},  // corners
                                                    {a, b, c, e},
                                                    {a, b, d, e},
                                                    {b, c, e, f},
                                                    {b, d, e, f}})  // the octahedron, about be
    sum += sampled_mean_of_exp(part, levels - 1);
  return sum / 8;
}

TEST(TetMeasures, MeanOfExpIsThatOverTheTet) {
  std::mt19937 random(3);
  for (const double reach : {1e-9, 0.1, 0.9, 1.1, 3.0, 6.0})
    for (int i = 0; i < 4; ++i) {
      std::uniform_real_distribution<double> within(0, reach);
      std::array<double, 4> x{within(random), within(random), within(random), within(random)};
      if (i == 0) x[1] = x[2] = x[0];
      if (i == 1) x[3] = x[1];
      const double sampled = sampled_mean_of_exp(x, 5);
      EXPECT_NEAR(mean_of_exp(x), sampled, (1e-12 + 1e-4 * reach * reach) * sampled) << reach;
    }
  for (const double x : {-800.0, 0.0, 3.0, 700.0}) {
    EXPECT_NEAR(mean_of_exp({x, x, x, x}), std::exp(x), 1e-9 * std::exp(x));
  }
  // One corner far from the others: the remainder of exp's series.
  for (const double x : {-50.0, -10.0, 10.0, 50.0, 300.0}) {
    const double exact = 6 * (std::exp(x) - 1 - x - x * x / 2) / (x * x * x);
    EXPECT_NEAR(mean_of_exp({0, x, 0, 0}), exact, 1e-9 * std::abs(exact)) << x;
  }
  EXPECT_LE(mean_of_exp({0, 1000, 2000, 2000}), std::numeric_limits<double>::max());
  EXPECT_GE(mean_of_exp({0, 1000, 2000, 2000}), 1e308);
}

TEST(TetMeasures, ExpectedComplexityIsTheQuadratureWhereSizesAreAlikeAndLessWhereTheyAreNot) {
  TetCorners upright = kRegular;
  std::swap(upright[0], upright[1]);
  std::mt19937 random(4);
  std::array<LogMetric, 4> log_metrics;
  log_metrics.fill(random_log_metric(random));
  const double even = density(log_metrics[0]);
  EXPECT_NEAR(expected_complexity(upright, log_metrics), complexity(upright, {even, even, even, even}),
              1e-9 * complexity(upright, {even, even, even, even}));
  EXPECT_EQ(expected_complexity(kRegular, log_metrics), 0);
  log_metrics[2] = log_metrics[2] + meshing::identity_tensor(2 * std::log(10.0));  // a tenth of the size
  EXPECT_NEAR(
      expected_complexity(upright, log_metrics) / complexity(upright, {even, even, 1000 * even, even}),
      0.0176 / 0.25075, 1e-3);
}

/// As one does that is exactly positive, and whose volume is rounded to less than nothing.
TEST(TetMeasures, ANegativeVolumeCountsAsNoneAndNoComplexityOverflows) {
  TetCorners upright = kRegular;
  std::swap(upright[0], upright[1]);
  const std::array<double, 4> usual{1, 2, 3, 4}, largest{1e308, 1e308, 1e308, 1e308};
  EXPECT_GT(complexity(upright, usual), 0);
  EXPECT_EQ(complexity(kRegular, usual), 0);
  EXPECT_LE(complexity(upright, largest), std::numeric_limits<double>::max());
}

TEST(TetMeasures, CutTensorsArePositiveAndFiniteForTetsBeyondAllMeasure) {
  TetCorners flat = kRegular, tiny = kRegular, huge = kRegular;
  for (Point& p : flat) p.z = 0;
  for (Point& p : tiny) p = 1e-200 * p;
  for (Point& p : huge) p = 1e200 * p;
  const LogMetric extreme{700, 0, -700, 0, 0, -700};
  for (const TetCorners& tet : {kRegular, flat, tiny, huge})
    for (const LogMetric& log_metric : {LogMetric{}, extreme}) {
      const double size = trace(cut_tensor(tet, unit_inverse(log_metric)));
      EXPECT_TRUE(size > 0 && size <= std::numeric_limits<double>::max()) << size;
    }
}

}  // namespace
}  // namespace weft::partition::tet_measures_test

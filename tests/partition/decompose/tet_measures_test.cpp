// Areas and cuts in a metric against what they are by definition.
#include "partition/decompose/tet_measures.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
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

// The judges' shortcuts against what they stand for.
#include "meshing/kernel/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "meshing/metric/metric.h"

namespace weft::meshing::quality_test {
namespace {

LogMetric random_logarithm(std::mt19937& random, double spread) {
  std::normal_distribution<double> x(0, spread);
  return {x(random), x(random), x(random), x(random), x(random), x(random)};
}

Corner random_corner(std::mt19937& random) {
  std::uniform_real_distribution<double> x(-1, 1);
  return {{x(random), x(random), x(random)}, exp_fast(random_logarithm(random, 1))};
}

TEST(Quality, AboveABoundIsTheQualityAndBelowItIsNone) {
  std::mt19937 random(7);
  int above = 0, below = 0, inverted = 0;
  for (int i = 0; i < 20000; ++i) {
    const Corner a = random_corner(random), b = random_corner(random), c = random_corner(random),
                 d = random_corner(random);
    const double q = judge_quality(MetricMean::arithmetic, a, b, c, d);
    const double bound = std::uniform_real_distribution<double>(0, 1)(random);
    const double bounded = judge_quality_above(bound, MetricMean::arithmetic, a, b, c, d);
    if (q < 0) {
      EXPECT_LT(bounded, 0);
      ++inverted;
    } else if (q > bound) {
      EXPECT_NEAR(bounded, q, 1e-12);
      ++above;
    } else {
      EXPECT_EQ(bounded, 0) << "quality " << q << ", bound " << bound;
      ++below;
    }
  }
  EXPECT_GT(above, 1000);
  EXPECT_GT(below, 1000);
  EXPECT_GT(inverted, 1000);
}

TEST(MetricLength, ComparesAsItsValueDoes) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> square(0, 4), bound(0, 2);
  int mixed = 0;
  for (int i = 0; i < 20000; ++i) {
    const MetricLength length{square(random), square(random)};
    const double l = bound(random);
    EXPECT_EQ(length.above(l), length.value() > l);
    EXPECT_EQ(length.below(l), length.value() < l);
    mixed += (length.a > l * l) != (length.b > l * l);
  }
  EXPECT_GT(mixed, 1000) << "the squares alone decided";
}

}  // namespace
}  // namespace weft::meshing::quality_test

// Sums in any order and in parts.
#include "meshing/base/fixed_point_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace weft::meshing::fixed_point_sum_test {
namespace {

double sum_of(const std::vector<double>& values, int exponent) {
  FixedPointSum sum;
  for (const double value : values) sum.add(value, exponent);
  return sum.value(exponent);
}

TEST(FixedPointSum, IsTheSameInAnyOrderAndInParts) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-3, 3);
  std::vector<double> values;
  for (int i = 0; i < 10000; ++i) values.push_back(u(random) * std::pow(10, -std::abs(u(random))));
  const int exponent = exponent_above(3);
  EXPECT_EQ(exponent, 2);
  const double expected = sum_of(values, exponent);
  for (int i = 0; i < 5; ++i) {
    std::ranges::shuffle(values, random);
    EXPECT_EQ(sum_of(values, exponent), expected);
    FixedPointSum parts[3], sum;
    for (std::size_t k = 0; k < values.size(); ++k) parts[k % 3].add(values[k], exponent);
    for (const FixedPointSum& part : parts) sum.add(part);
    EXPECT_EQ(sum.value(exponent), expected);
  }
  long double exact = 0;
  for (const double value : values) exact += static_cast<long double>(value);
  EXPECT_NEAR(expected, static_cast<double>(exact), 1e-15 * std::abs(expected) + 1e-17);
}

TEST(FixedPointSum, LosesNothingOfFewAndCancelsExactly) {
  EXPECT_EQ(sum_of({0.1}, exponent_above(0.1)), 0.1);
  EXPECT_NEAR(sum_of({1e9, 1e-9, -1e9}, exponent_above(1e9)), 1e-9, 1e-16);
  EXPECT_EQ(sum_of({-0.3, 0.3}, 0), 0);
  EXPECT_EQ(sum_of({}, exponent_above(0)), 0);
}

}  // namespace
}  // namespace weft::meshing::fixed_point_sum_test

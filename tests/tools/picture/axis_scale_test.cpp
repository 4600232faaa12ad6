// Ticks.
#include "tools/picture/axis_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace weft::picture::axis_scale_test {
namespace {

TEST(AxisScale, LinearTicksAreRoundAndLabelledDistinctly) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-5, 5), exponent(-12, 12);
  for (int trial = 0; trial < 500; ++trial) {
    const double size = std::pow(10, exponent(random)), lo = size * place(random), hi = lo + size;
    const auto ticks = linear_ticks(lo, hi, 6);
    ASSERT_GE(ticks.size(), 2u);
    EXPECT_LE(ticks.size(), 7u);
    std::set<std::string> labels;
    const double step = ticks[1].value - ticks[0].value;
    for (const Tick& tick : ticks) {
      EXPECT_GE(tick.value, lo - 1e-6 * size);
      EXPECT_LE(tick.value, hi + 1e-6 * size);
      EXPECT_NEAR(std::stod(tick.label), tick.value, 1e-6 * step) << tick.label;
      labels.insert(tick.label);
    }
    EXPECT_EQ(labels.size(), ticks.size());
    const double mantissa = step / std::pow(10, std::floor(std::log10(step) + 1e-9));
    EXPECT_TRUE(std::abs(mantissa - 1) < 1e-6 || std::abs(mantissa - 2) < 1e-6 ||
                std::abs(mantissa - 5) < 1e-6);
  }
}

TEST(AxisScale, NothingToMarkHasNoTicks) {
  EXPECT_TRUE(linear_ticks(1, 1, 5).empty());
  EXPECT_TRUE(linear_ticks(2, 1, 5).empty());
  EXPECT_TRUE(linear_ticks(0, std::numeric_limits<double>::infinity(), 5).empty());
}

TEST(AxisScale, EndsThatDifferByRoundingAloneHaveNoTicks) {
  for (const double lo : {1e-300, 0.1, 1.0, 101325.0, 1e300})
    for (const double sign : {1.0, -1.0}) {
      const double next = std::nextafter(sign * lo, HUGE_VAL), over = std::nextafter(next, HUGE_VAL);
      EXPECT_TRUE(linear_ticks(sign * lo, next, 6).empty()) << sign * lo;
      EXPECT_TRUE(linear_ticks(sign * lo, over, 6).empty()) << sign * lo;
    }
}

TEST(AxisScale, DecadesAreNotTooMany) {
  for (int hi = 0; hi < 40; ++hi) {
    const auto ticks = decade_ticks(0, hi, 7);
    EXPECT_EQ(ticks.front().label, "1");
    EXPECT_LE(ticks.size(), 8u);
    EXPECT_GE(ticks.size(), std::min<std::size_t>(static_cast<std::size_t>(hi) + 1, 4));
  }
  EXPECT_EQ(decade_ticks(0, 6, 7).back().label, "10⁶");
  EXPECT_EQ(decade_ticks(-12, -12, 7).back().label, "10⁻¹²");
}

}  // namespace
}  // namespace weft::picture::axis_scale_test

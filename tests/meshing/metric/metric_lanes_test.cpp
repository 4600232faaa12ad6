// Logarithms and exponentials of eight tensors at a time are those of one at a time.
#include "meshing/metric/metric_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace weft::meshing::metric_lanes_test {
namespace {

/// A symmetric tensor in any axes, with these eigenvalues.
SymTensor turned(std::mt19937& random, const std::array<double, 3>& values) {
  std::normal_distribution<double> normal;
  const auto any = [&] { return Vec{normal(random), normal(random), normal(random)}; };
  Vec a = any(), c = cross(a, any());
  a = (1 / norm(a)) * a, c = (1 / norm(c)) * c;
  return from_eigen({values, {a, cross(c, a), c}});
}

double largest_entry(const SymTensor& a) {
  return std::max(
      {std::abs(a.xx), std::abs(a.xy), std::abs(a.yy), std::abs(a.xz), std::abs(a.yz), std::abs(a.zz)});
}

TEST(MetricLanes, LogarithmsAreThoseByEigenvalues) {
  std::mt19937 random(2);
  for (const double ratio : {0.0, 1.0, 4.0, 8.0}) {
    std::uniform_real_distribution<double> size(-ratio, ratio);
    for (int k = 0; k < 50; ++k) {
      std::array<SymTensor, 8> metrics;
      std::array<LogMetric, 8> logs;
      for (SymTensor& m : metrics)
        m = turned(random, {std::exp(size(random)), std::exp(size(random)), std::exp(size(random))});
      ASSERT_EQ(logs_of(metrics, logs), 0u);
      for (std::size_t i = 0; i < 8; ++i)
        EXPECT_LE(largest_entry(logs[i] - log_of(metrics[i])), 1e-14 * std::exp(2 * ratio)) << ratio;
    }
  }
}

TEST(MetricLanes, ExponentialsAreThoseByEigenvalues) {
  std::mt19937 random(3);
  for (const double range : {0.0, 1.0, 20.0}) {
    std::uniform_real_distribution<double> value(-range, range);
    for (int k = 0; k < 50; ++k) {
      std::array<LogMetric, 8> logs;
      std::array<Metric, 8> metrics;
      for (LogMetric& l : logs) l = turned(random, {value(random), value(random), value(random)});
      exps_of(logs, metrics);
      for (std::size_t i = 0; i < 8; ++i) {
        const Metric expected = exp_exact(logs[i]);
        EXPECT_LE(largest_entry(metrics[i] - expected), 2e-13 * largest_entry(expected)) << range;
      }
    }
  }
}

TEST(MetricLanes, WhatIsNotClearlyDefiniteIsLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  std::mt19937 random(4);
  const std::array<SymTensor, 7> metrics = {{{2, 0, 3, 0, 0, 4},
                                             turned(random, {-1, 1, 2}),
                                             {nan, 0, 1, 0, 0, 1},
                                             {1, 0, inf, 0, 0, 1},
                                             {},
                                             turned(random, {1e-20, 1, 1}),
                                             {5, 1, 5, 1, 1, 5}}};
  std::array<LogMetric, 7> logs;
  EXPECT_EQ(logs_of(metrics, logs), 0b0111110u);
  EXPECT_NEAR(logs[0].yy, std::log(3), 1e-15);
  EXPECT_LE(largest_entry(logs[6] - log_of(metrics[6])), 1e-14);
}

TEST(MetricLanes, WhatATensorGetsDoesNotDependOnThoseBesideIt) {
  std::mt19937 random(5);
  std::array<SymTensor, 8> metrics;
  for (SymTensor& m : metrics) m = turned(random, {1, 20, 300});
  std::array<LogMetric, 8> together, alone;
  logs_of(metrics, together);
  for (std::size_t i = 0; i < 8; ++i) {
    logs_of(std::span(metrics).subspan(i, 1), std::span(alone).subspan(i, 1));
    EXPECT_EQ(alone[i], together[i]);
  }
}

}  // namespace
}  // namespace weft::meshing::metric_lanes_test

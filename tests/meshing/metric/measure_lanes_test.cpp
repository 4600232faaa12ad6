// Measures with the arithmetic of eight at a time are those of one at a time.
#include "meshing/metric/measure_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "meshing/metric/measures.h"

namespace weft::meshing::measure_lanes_test {
namespace {

/// Symmetric, its entries of the size of `scale`.
SymTensor random_tensor(std::mt19937& random, double scale) {
  std::normal_distribution<double> normal(0, scale);
  return {normal(random), normal(random), normal(random), normal(random), normal(random), normal(random)};
}

Point random_point(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return {uniform(random), uniform(random), uniform(random)};
}

TEST(MeasureLanes, LogarithmsAreThoseOfTheLibrary) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-600, 600);
  for (int k = 0; k < 2000; ++k) {
    Lanes x;
    for (int i = 0; i < kLanes; ++i) x[i] = k == 0 ? 1 + 1e-12 * i : std::exp(exponent(random));
    const Lanes logs = log_of_lanes(x);
    for (int i = 0; i < kLanes; ++i)
      EXPECT_NEAR(logs[i], std::log(x[i]), 4e-16 * std::max(1.0, std::abs(std::log(x[i]))));
  }
}

TEST(MeasureLanes, WhatHasNoLogarithmIsBelowAllIntervals) {
  const Lanes logs = log10_for_bins(Lanes{0, -1, -1e-300, 10, 100, 1, 0.1, 1e-3});
  EXPECT_LT(logs[0], -200);
  EXPECT_LT(logs[1], -200);
  EXPECT_LT(logs[2], -200);
  EXPECT_NEAR(logs[3], 1, 1e-15);
  EXPECT_NEAR(logs[7], -3, 1e-15);
}

/// Of up to more anisotropy than exp_of_traceless serves, and of tets that are inverted or flat.
TEST(MeasureLanes, MeanRatiosAreThoseOfSingleTets) {
  std::mt19937 random(2);
  for (const double scale : {0.0, 0.1, 1.0, 3.0, 10.0}) {
    std::vector<Point> points;
    std::vector<LogMetric> logs;
    for (int i = 0; i < 60; ++i)
      points.push_back(random_point(random)), logs.push_back(random_tensor(random, scale));
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (std::uint32_t i = 0; i < 57; ++i) tets.push_back({i, i + 1, i + 2, i + 3});
    points[1] = points[0];  // flat: its mean ratio is zero
    for (std::size_t first = 0; first < tets.size(); first += kLanes) {
      const Lanes ratios = mean_ratios(tets, first, points, logs);
      for (std::size_t t = first; t < std::min(tets.size(), first + kLanes); ++t) {
        const auto& [a, b, c, d] = tets[t];
        const double expected =
            mean_ratio({points[a], points[b], points[c], points[d]}, {logs[a], logs[b], logs[c], logs[d]});
        EXPECT_NEAR(ratios[static_cast<int>(t - first)], expected, 1e-8 * std::abs(expected)) << scale;
      }
    }
  }
}

TEST(MeasureLanes, ARatioDoesNotDependOnTheTetsBeside) {
  std::mt19937 random(3);
  std::vector<Point> points;
  std::vector<LogMetric> logs;
  for (int i = 0; i < 20; ++i)
    points.push_back(random_point(random)), logs.push_back(random_tensor(random, 2));
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i < 17; ++i) tets.push_back({i, i + 1, i + 2, i + 3});
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const std::size_t lane = std::min<std::size_t>(t, 5);
    EXPECT_EQ(mean_ratios(tets, t, points, logs)[0],
              mean_ratios(tets, t - lane, points, logs)[static_cast<int>(lane)]);
  }
}

TEST(MeasureLanes, LengthsAreThoseOfSingleEdges) {
  std::mt19937 random(4);
  EdgeBatch batch;
  std::vector<double> expected;
  for (int i = 0; i < kLanes; ++i) {
    const Vec edge = random_point(random) - Point{};
    const Metric a = exp_exact(random_tensor(random, 2)), b = i % 2 ? a : exp_exact(random_tensor(random, 2));
    batch.add(edge, a, b);
    expected.push_back(edge_length(edge, a, b));
  }
  ASSERT_EQ(batch.size(), kLanes);
  const Lanes lengths = batch.take_lengths();
  EXPECT_EQ(batch.size(), 0);
  for (int i = 0; i < kLanes; ++i)
    EXPECT_NEAR(lengths[i], expected[static_cast<std::size_t>(i)],
                1e-12 * expected[static_cast<std::size_t>(i)]);
}

/// Strongly anisotropic ones too.
TEST(MeasureLanes, TetsAreMeasuredInTheirMeanMetrics) {
  std::mt19937 random(5);
  for (const double scale : {0.0, 1.0, 3.0, 10.0}) {
    std::vector<Point> points;
    std::vector<LogMetric> logs;
    for (int i = 0; i < 22; ++i)
      points.push_back(random_point(random)), logs.push_back(random_tensor(random, scale));
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (std::uint32_t i = 0; i < 19; ++i) tets.push_back({i, i + 1, i + 2, i + 3});
    for (std::size_t first = 0; first < tets.size(); first += kLanes) {
      const TetLanes lanes = measure_tets(tets, first, points, logs);
      const Lanes ratios = mean_ratios(tets, first, points, logs);
      for (std::size_t t = first; t < std::min(tets.size(), first + kLanes); ++t) {
        const auto lane = static_cast<int>(t - first);
        const auto& [a, b, c, d] = tets[t];
        const Metric mean = exp_fast(0.25 * (logs[a] + logs[b] + logs[c] + logs[d]));
        EXPECT_EQ(lanes.ratios[lane], ratios[lane]);
        const double volume = six_volume(points[a], points[b], points[c], points[d]) / 6 *
                              std::exp(0.125 * trace(logs[a] + logs[b] + logs[c] + logs[d]));
        EXPECT_NEAR(lanes.volumes[lane], volume, 1e-9 * std::abs(volume));
        std::array<double, 6> lengths,
            expected = {
                squared_length(mean, points[b] - points[a]), squared_length(mean, points[c] - points[a]),
                squared_length(mean, points[d] - points[a]), squared_length(mean, points[c] - points[b]),
                squared_length(mean, points[d] - points[b]), squared_length(mean, points[d] - points[c])};
        for (std::size_t e = 0; e < 6; ++e) lengths[e] = lanes.squared_lengths[e][lane];
        const double largest = *std::ranges::max_element(expected);
        for (std::size_t e = 0; e < 6; ++e) EXPECT_NEAR(lengths[e], expected[e], 1e-7 * largest) << scale;
      }
    }
  }
}

}  // namespace
}  // namespace weft::meshing::measure_lanes_test

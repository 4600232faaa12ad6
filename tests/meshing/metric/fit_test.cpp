// What weft has adapted fits its metric; in a metric that is a little off, in all or in a part, it does not.
#include "meshing/metric/fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>

#include "meshing/metric/measures.h"
#include "tests/support/fitting_mesh.h"

namespace weft::meshing::fit_test {
namespace {

using support::fitting_mesh;
using support::MetricMesh;

bool fits(const MetricMesh& m) { return fit_of(m.mesh, m.log_metrics).has_value(); }

/// The mesh in the metric in which lengths are longer by factor(point).
MetricMesh in_metric(const std::function<double(const Point&)>& factor) {
  MetricMesh m = fitting_mesh();
  for (std::size_t v = 0; v < m.mesh.points.size(); ++v)
    m.log_metrics[v] = support::times(factor(m.mesh.points[v]), m.log_metrics[v]);
  return m;
}

TEST(Fit, AnAdaptedMeshFits) {
  const MetricMesh& m = fitting_mesh();
  ASSERT_GE(blocks_of(m.mesh.tets.size()), 3u);
  const auto fit = fit_of(m.mesh, m.log_metrics);
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->edges_short, 0.01);
  EXPECT_LT(fit->edges_long, 0.002);
  const Measures measures = measure(m.mesh, m.log_metrics);
  EXPECT_NEAR(fit->quality_mean, measures.quality_mean, 1e-8);
  EXPECT_NEAR(fit->tets_of_complexity, static_cast<double>(measures.num_tets) / measures.complexity, 1e-6);
}

TEST(Fit, EdgesFivePercentOffDoNot) {
  for (const double factor : {0.9, 0.95, 1.05, 1.1})
    EXPECT_FALSE(fits(in_metric([&](const Point&) { return factor; }))) << factor;
}

TEST(Fit, NorInAPart) {
  for (const double factor : {0.95, 1.05})
    EXPECT_FALSE(fits(in_metric([&](const Point& p) { return p.z < 0.6 ? factor : 1; }))) << factor;
  for (const double factor : {0.5, 2.0})  // of a few hundred tets
    EXPECT_FALSE(fits(in_metric([&](const Point& p) {
      return norm(p - Point{0.5, 0.5, 1}) < 0.25 ? factor : 1;
    }))) << factor;
}

TEST(Fit, OneTetOrEdgeThatIsWrongDecides) {
  MetricMesh m = fitting_mesh();
  const std::uint32_t v = m.mesh.tets[m.mesh.tets.size() / 2][0];
  m.log_metrics[v] = support::times(8, m.log_metrics[v]);
  EXPECT_FALSE(fits(m));
  m = fitting_mesh();
  std::swap(m.mesh.tets[7][0], m.mesh.tets[7][1]);
  EXPECT_FALSE(fits(m));
  m = fitting_mesh();
  m.log_metrics[v].xx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(fits(m));
}

TEST(Fit, TetsInAnyOrderAreNotJudged) {
  MetricMesh m = fitting_mesh();
  EXPECT_TRUE(count_followers(m.mesh.tets).in_order());
  std::ranges::shuffle(m.mesh.tets, std::mt19937(1));
  EXPECT_FALSE(count_followers(m.mesh.tets).in_order());
  EXPECT_FALSE(fits(m));
}

TEST(Fit, FewTetsAreNotJudged) {
  const MetricMesh m = support::fitting_mesh(0.2);
  ASSERT_GT(m.mesh.tets.size(), 1000u);
  ASSERT_EQ(blocks_of(m.mesh.tets.size()), 0u);
  EXPECT_FALSE(fits(m));
  EXPECT_FALSE(fit_of(MeshData(), {}));
}

TEST(Fit, SumsOfPartsAddUpToTheSame) {
  const MetricMesh& m = fitting_mesh();
  const std::span tets(m.mesh.tets);
  const auto sums_of = [&](std::size_t begin, std::size_t end) {
    return *sum_blocks(tets.subspan(begin, end - begin), begin, tets.size(), m.mesh.points, m.log_metrics);
  };
  const FitBlocks whole = sums_of(0, tets.size());
  ASSERT_EQ(whole.sums.size(), blocks_of(tets.size()));
  std::map<std::uint64_t, FitSums> joined;
  const std::size_t cuts[] = {0, 0, 5, 9001, 9002, 20000, tets.size(), tets.size()};
  for (std::size_t c = 1; c < std::size(cuts); ++c) {
    const FitBlocks part = sums_of(cuts[c - 1], cuts[c]);
    for (std::size_t b = 0; b < part.sums.size(); ++b) joined[part.first + b] += part.sums[b];
  }
  for (std::size_t b = 0; b < whole.sums.size(); ++b) EXPECT_EQ(joined[b], whole.sums[b]) << b;
}

}  // namespace
}  // namespace weft::meshing::fit_test

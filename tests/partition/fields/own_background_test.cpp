// A background that is another mesh: the same metric and the same pieces for every subdomain on any number of
// ranks, and all of it that a subdomain needs.
#include "partition/fields/own_background.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <random>
#include <utility>

#include "meshing/fields/tet_locator.h"
#include "partition/distribute/distribute.h"
#include "partition/fields/tets_meet.h"
#include "partition/subdomain/subdomain.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::partition::own_background_test {
namespace {

using meshing::Background;
using meshing::LogMetric;
using meshing::Point;
using support::MetricMesh;

constexpr std::uint32_t kSubdomains = 5;

MetricMesh with_metric(meshing::MeshData mesh, double jitter, unsigned seed) {
  support::jitter_interior(mesh, jitter, seed);
  support::shuffle(mesh, seed);
  meshing::LogMetricField metric;
  for (const Point& p : mesh.points) metric.push_back({p.x, p.y * p.z, 3 - p.y, 0.1 * p.z, 0.2, p.x * p.x});
  return {std::move(mesh), std::move(metric)};
}

struct Outcome {
  std::vector<LogMetric> log_metrics;              ///< of the input's points
  std::map<std::uint32_t, SubdomainStart> starts;  ///< by subdomain
  double complexity = 0;
  meshing::Uncovered uncovered;
};

Outcome run_on(int ranks, unsigned seed, const MetricMesh& background, const meshing::MeshData& input) {
  Outcome run;
  std::mutex mutex;
  std::vector<std::vector<LogMetric>> of_rank(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& peers) {
    MeshSlice slice = support::slice_of({input, {}}, peers.rank(), ranks, seed);
    const OwnBackground own(peers, support::slice_of(background, peers.rank(), ranks, seed + 1), slice);
    of_rank[static_cast<std::size_t>(peers.rank())] = slice.log_metrics;
    DecompositionOptions options;
    options.num_subdomains = kSubdomains;
    options.partitioner = parse_partitioner("graph", kSubdomains);
    Distributed d = distribute(peers, std::move(slice), options);
    own.deliver(d.starts);
    const std::lock_guard lock(mutex);
    run.complexity = own.complexity();
    run.uncovered = own.uncovered();
    for (SubdomainStart& s : d.starts) run.starts.emplace(s.subdomain.value, std::move(s));
  });
  for (const auto& part : of_rank) run.log_metrics.insert(run.log_metrics.end(), part.begin(), part.end());
  return run;
}

class OwnBackgroundOnRanks : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Ranks, OwnBackgroundOnRanks, testing::ValuesIn(support::kNumbersOfRanks));

TEST_P(OwnBackgroundOnRanks, CountsThePointsThatLieOutsideIt) {
  MetricMesh background = with_metric(support::unit_cube(6), 0.02, 1);
  for (Point& p : background.mesh.points) p.x *= 0.75;
  const meshing::MeshData input = with_metric(support::unit_cube(5), 0, 2).mesh;
  const meshing::Uncovered whole = meshing::uncovered(background.mesh, input);
  EXPECT_EQ(whole.vertices, 2 * 36u);  // at x = 0.8 and 1
  EXPECT_NEAR(whole.farthest, 0.25, 1e-12);
  const meshing::Uncovered many = run_on(GetParam(), 7, background, input).uncovered;
  EXPECT_EQ(many.vertices, whole.vertices);
  EXPECT_DOUBLE_EQ(many.farthest, whole.farthest);
}

TEST_P(OwnBackgroundOnRanks, GivesEverySubdomainTheSameBits) {
  const MetricMesh background = with_metric(support::unit_cube(9), 0.02, 1);
  const meshing::MeshData input = with_metric(support::unit_cube(5), 0.03, 2).mesh;
  const Outcome one = run_on(1, 0, background, input), many = run_on(GetParam(), 7, background, input);
  EXPECT_EQ(many.log_metrics, one.log_metrics);
  EXPECT_EQ(many.complexity, one.complexity);
  ASSERT_EQ(many.starts.size(), kSubdomains);
  std::size_t pieces = 0;
  for (const auto& [id, start] : many.starts) {
    const SubdomainStart& expected = one.starts.at(id);
    ASSERT_EQ(start.background.size(), expected.background.size());
    pieces += start.background.size();
    for (std::size_t p = 0; p < start.background.size(); ++p) {
      const BackgroundPiece &a = *start.background[p], &b = *expected.background[p];
      EXPECT_TRUE(std::ranges::equal(a.bytes(), b.bytes())) << a.id << " " << b.id;
    }
    ASSERT_EQ(start.background_places.size(), start.points.size());
    for (std::size_t v = 0; v < start.points.size(); ++v) {
      EXPECT_EQ(start.background_places[v].piece, expected.background_places[v].piece);
      EXPECT_EQ(start.background_places[v].tet, expected.background_places[v].tet);
    }
  }
  EXPECT_LT(pieces, kSubdomains * (background.mesh.tets.size() / kTetsOfPiece + 1))
      << "not all need all of it";
}

TEST_P(OwnBackgroundOnRanks, AnswersAsTheWholeBackgroundInEverySubdomain) {
  const MetricMesh background = with_metric(support::unit_cube(9), 0.02, 3);
  const meshing::MeshData input = with_metric(support::unit_cube(4), 0.03, 4).mesh;
  const Background whole(background.mesh, background.log_metrics,
                         meshing::build_adjacency(background.mesh.tets, background.mesh.points.size()));
  const Outcome run = run_on(GetParam(), 3, background, input);
  std::mt19937 random(5);
  const auto share = [&] { return static_cast<double>(random()) / 4294967296.0 + 1e-3; };
  for (const auto& [id, start] : run.starts) {
    const Subdomain subdomain(start, 100000);
    EXPECT_TRUE(subdomain.background.of_another_mesh());
    for (std::size_t t = 0; t < start.tets.size(); ++t)
      for (int sample = 0; sample < 4; ++sample) {
        Point p;
        double sum = 0;
        for (const std::uint32_t v : start.tets[t]) {
          const double weight = share();
          p += weight * start.points[v];
          sum += weight;
        }
        p = (1 / sum) * p;
        const std::uint32_t hint = subdomain.mesh->background_hint(meshing::VertexId(start.tets[t][0]));
        const LogMetric here = subdomain.background.background().at(p, hint).log_metric,
                        there = whole.at(p, Background::kNoHint).log_metric;
        for (const auto member :
             {&LogMetric::xx, &LogMetric::xy, &LogMetric::yy, &LogMetric::xz, &LogMetric::yz, &LogMetric::zz})
          ASSERT_NEAR(here.*member, there.*member, 1e-12);
      }
  }
}

/// Most of the input lies far from the background.
TEST_P(OwnBackgroundOnRanks, VerticesBeyondTheBackgroundReadItsClosestPoint) {
  const MetricMesh background = with_metric(support::unit_cube(9), 0.02, 1);
  meshing::MeshData input = support::unit_cube(5);
  for (Point& p : input.points) p = {4 * p.x - 1, 4 * p.y - 1, 4 * p.z - 1};
  const meshing::TetLocator whole(
      background.mesh, meshing::build_adjacency(background.mesh.tets, background.mesh.points.size()));
  const Outcome run = run_on(GetParam(), 5, background, input);
  for (std::size_t v = 0; v < input.points.size(); ++v) {
    const meshing::TetLocator::Place place = whole.locate(input.points[v], meshing::TetLocator::kNoHint);
    LogMetric expected;
    for (std::size_t i = 0; i < 4; ++i)
      expected = expected + place.at[i] * background.log_metrics[background.mesh.tets[place.tet][i]];
    ASSERT_NEAR(run.log_metrics[v].yy, expected.yy, 1e-9);
    ASSERT_NEAR(run.log_metrics[v].xz, expected.xz, 1e-9);
  }
  for (const auto& [id, start] : run.starts) EXPECT_FALSE(start.background.empty());
}

TEST(TetsMeet, WhereTheyHaveAPointInCommon) {
  const TetCorners tet{Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}};
  const auto moved = [&](double x, double y, double z) {
    TetCorners other = tet;
    for (Point& p : other) p += Point{x, y, z};
    return other;
  };
  EXPECT_TRUE(tets_meet(tet, moved(0, 0, 0)));
  EXPECT_TRUE(tets_meet(tet, moved(0.3, 0.3, 0.3)));
  EXPECT_TRUE(tets_meet(tet, moved(1, 0, 0))) << "at a vertex";
  EXPECT_FALSE(tets_meet(tet, moved(0.4, 0.4, 0.4))) << "boxes meet, tets do not";
  EXPECT_FALSE(tets_meet(tet, moved(1.01, 0, 0)));
  // Edges cross beside each other: no face separates them.
  const TetCorners a{Point{-1, 0, 0}, Point{1, 0, 0}, Point{0, 1, -1}, Point{0, -1, -1}};
  const TetCorners b{Point{0, -1, 0.1}, Point{0, 1, 0.1}, Point{1, 0, 1}, Point{-1, 0, 1}};
  EXPECT_FALSE(tets_meet(a, b));
  TetCorners lower = b;
  for (Point& p : lower) p.z -= 0.2;
  EXPECT_TRUE(tets_meet(a, lower));
}

}  // namespace
}  // namespace weft::partition::own_background_test

// Tests of states between passes: an adaptation that goes on from any of them ends as one that nobody
// disturbs.
#include "meshing/adapt/adaptation_state.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <utility>
#include <vector>

#include "meshing/adapt/adapt.h"
#include "meshing/mesh/check_mesh.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"
#include "tests/support/repetitions.h"

namespace weft::meshing::adaptation_state_test {
namespace {

using support::uniform_metric;
using support::unit_cube;

struct KeepAll final : StateKeeper {
  bool wanted() override { return true; }
  void keep(const std::function<AdaptationState()>& copy) override { states.push_back(copy()); }
  std::vector<AdaptationState> states;
};

struct Case {
  MeshData mesh;
  LogMetricField metric;

  AdaptResult adapted(const AdaptOptions& options = {}) const {
    return adapt(mesh, {&mesh, &metric}, options);
  }
};

/// A plane layer at x = 0.5: levels, rounds, many holes.
Case layer(std::uint32_t cells) {
  Case c{unit_cube(cells), {}};
  for (const Point& p : c.mesh.points) {
    const double h = 0.03 + 0.5 * std::abs(p.x - 0.5), across = 0.25;
    c.metric.push_back({-2 * std::log(h), 0, -2 * std::log(across), 0, 0, -2 * std::log(across)});
  }
  return c;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

bool same_bytes(const AdaptResult& a, const AdaptResult& b) {
  return same_bits(a.mesh.points, b.mesh.points) && same_bits(a.mesh.tets, b.mesh.tets) &&
         same_bits(a.mesh.triangles, b.mesh.triangles) && same_bits(a.mesh.edges, b.mesh.edges) &&
         same_bits(a.mesh.corners, b.mesh.corners) && same_bits(a.log_metrics, b.log_metrics);
}

void expect_all_states_lead_to_the_same(const Case& c) {
  KeepAll keeper;
  AdaptOptions keeping;
  keeping.states = &keeper;
  const AdaptResult expected = c.adapted();
  ASSERT_TRUE(same_bytes(c.adapted(keeping), expected)) << "keeping states changes nothing";
  ASSERT_GT(keeper.states.size(), 20u);
  for (std::size_t i = 0; i < keeper.states.size();
       i += support::repetitions(1 + i % 5, 1)) {  // passes of all kinds
    AdaptOptions options;
    options.resume = &keeper.states[i];
    const AdaptResult resumed = c.adapted(options);
    ASSERT_TRUE(same_bytes(resumed, expected)) << "after pass " << i;
    ASSERT_EQ(resumed.report.stages.size(), expected.report.stages.size());
    ASSERT_EQ(resumed.report.counts.of, expected.report.counts.of) << "after pass " << i;
    ASSERT_EQ(resumed.report.share_wrong, expected.report.share_wrong);
  }
}

TEST(AdaptationState, AfterEachPassLeadsToTheSameBytesAndCounts) {
  expect_all_states_lead_to_the_same(layer(3));
}

TEST(AdaptationState, OfAMeshThatIsFarTooFineLeadsToTheSame) {
  Case c{unit_cube(9), {}};
  c.metric = uniform_metric(c.mesh, 0.4);
  expect_all_states_lead_to_the_same(c);
}

TEST(AdaptationState, OfACurvedBoundaryLeadsToTheSame) {
  Case c{support::ball(1, 2), {}};
  c.metric = uniform_metric(c.mesh, 0.5);
  expect_all_states_lead_to_the_same(c);
}

TEST(AdaptationState, KeptWhileItGoesOnFromOneIsAStateToo) {
  const Case c = layer(3);
  const AdaptResult expected = c.adapted();
  KeepAll first, second;
  AdaptOptions options;
  options.states = &first;
  c.adapted(options);
  options.states = &second;
  options.resume = &first.states[first.states.size() / 3];
  c.adapted(options);
  ASSERT_LT(second.states.size(), first.states.size()) << "what was done before is not done again";
  options.states = nullptr;
  options.resume = &second.states[second.states.size() / 2];
  EXPECT_TRUE(same_bytes(c.adapted(options), expected));
}

TEST(AdaptationState, GoesOnWithOtherThreads) {
  const Case c = layer(4);
  for (const auto& [before, after] : {std::pair{3, 1}, std::pair{1, 3}, std::pair{3, 2}}) {
    KeepAll keeper;
    AdaptOptions options;
    options.threads = before;
    options.states = &keeper;
    c.adapted(options);
    options.states = nullptr;
    options.threads = after;
    for (std::size_t i = 0; i < keeper.states.size(); i += 7) {
      options.resume = &keeper.states[i];
      const AdaptResult resumed = c.adapted(options);
      EXPECT_TRUE(check_mesh(resumed.mesh).problems.empty()) << before << " threads, then " << after;
    }
  }
}

/// Says after so many passes that the run is to end.
struct EndAfter final : StateKeeper {
  explicit EndAfter(int passes) : left(passes) {}
  bool wanted() override {
    if (--left == 0) interrupt = true;
    return true;
  }
  void keep(const std::function<AdaptationState()>& copy) override { last = copy(); }
  int left;
  std::atomic<bool> interrupt = false;
  AdaptationState last;
};

TEST(AdaptationState, BeforeAnInterruptionLeadsToWhatTheRunWouldHaveBecome) {
  const Case c = layer(3);
  const AdaptResult expected = c.adapted();
  for (const int passes : {1, 5, 20}) {
    EndAfter keeper(passes);
    AdaptOptions options;
    options.states = &keeper;
    options.interrupt = &keeper.interrupt;
    EXPECT_TRUE(c.adapted(options).report.interrupted);
    AdaptOptions resuming;
    resuming.resume = &keeper.last;
    EXPECT_TRUE(same_bytes(c.adapted(resuming), expected)) << "after " << passes;
  }
}

}  // namespace
}  // namespace weft::meshing::adaptation_state_test

// Rows of the timeline: the worker that ran a node, or as few rows as hold all.
#include "tools/report/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/simulated_run.h"

namespace weft::report::lanes_test {
namespace {

using graph::dataflow::GraphDump;
using weft::testing::SimulatedRun;
using weft::testing::SimulationRules;

struct ExampleRun {
  SimulatedRun simulated;
  GraphDump graph;
  engine::TimePoint start = 0;
};

ExampleRun run_of(const SimulationRules& rules) {
  ExampleRun run;
  run.simulated = weft::testing::simulate(rules);
  run.graph = graph::dataflow::executed_dump(run.simulated.graph, run.simulated.log, [&](engine::ObjectId o) {
    return weft::testing::subdomain_of_object(rules, o);
  });
  run.start = graph::dataflow::start_of(run.simulated.log);
  return run;
}

/// Runs in one row follow one another, and rows are of the runs' ranks.
void expect_rows(const GraphDump& graph, const Lanes& lanes) {
  ASSERT_EQ(lanes.of_run.size(), graph.runs.size());
  std::map<std::uint32_t, engine::TimePoint> free_at;
  for (std::size_t r = 0; r < graph.runs.size(); ++r) {
    ASSERT_TRUE(lanes.of_run[r]);
    const std::uint32_t lane = *lanes.of_run[r];
    EXPECT_EQ(lanes.lanes.at(lane).rank, graph.runs[r].rank);
    EXPECT_LE(free_at[lane], graph.runs[r].begin);
    free_at[lane] = graph.runs[r].end;
  }
  EXPECT_TRUE(std::is_sorted(lanes.lanes.begin(), lanes.lanes.end(),
                             [](const Lane& a, const Lane& b) { return a.rank < b.rank; }));
}

TEST(Lanes, AreTheWorkersThatRanTheNodes) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SimulationRules rules{
        .subdomains = 13, .ranks = 3, .workers = 2, .rounds = 3, .migration = seed % 2 == 0, .seed = seed};
    const ExampleRun run = run_of(rules);
    const Lanes lanes = lanes_of(run.graph, run.simulated.timelines, run.start);
    expect_rows(run.graph, lanes);
    EXPECT_EQ(lanes.lanes.size(), rules.ranks * rules.workers);
    for (const Lane& lane : lanes.lanes) EXPECT_EQ(lane.name.substr(0, 7), "worker ");
  }
}

TEST(Lanes, FollowTheClocksOfTheRanks) {
  ExampleRun run = run_of({.subdomains = 7, .ranks = 2, .workers = 2, .rounds = 2});
  for (engine::RankTimeline& timeline : run.simulated.timelines) {
    timeline.clock_offset = 77'000'000 * (timeline.rank.value + 1);
    for (auto& lane : timeline.lanes)
      for (auto& span : lane.spans) span.begin -= timeline.clock_offset, span.end -= timeline.clock_offset;
  }
  const Lanes lanes = lanes_of(run.graph, run.simulated.timelines, run.start);
  expect_rows(run.graph, lanes);
  EXPECT_EQ(lanes.lanes.size(), 4u);
}

TEST(Lanes, AreAsFewRowsAsHoldAllRunsWhereNothingIsKnownOfWorkers) {
  const ExampleRun run = run_of({.subdomains = 13, .ranks = 3, .workers = 2, .rounds = 3});
  const Lanes lanes = lanes_of(run.graph, {}, run.start);
  expect_rows(run.graph, lanes);
  EXPECT_LE(lanes.lanes.size(), 6u);  // that is how many workers there were
  EXPECT_EQ(lanes.lanes.front().name, "row 0");
}

TEST(Lanes, AreNoneOfRanksWithoutATimelineWhereOthersHaveOne) {
  ExampleRun run = run_of({.subdomains = 13, .ranks = 3, .workers = 2, .rounds = 3});
  std::erase_if(run.simulated.timelines, [](const auto& timeline) { return timeline.rank.value == 1; });
  const Lanes lanes = lanes_of(run.graph, run.simulated.timelines, run.start);
  EXPECT_EQ(lanes.lanes.size(), 4u);
  ASSERT_EQ(lanes.of_run.size(), run.graph.runs.size());
  std::size_t shown = 0;
  for (std::size_t r = 0; r < run.graph.runs.size(); ++r) {
    ASSERT_EQ(lanes.of_run[r].has_value(), run.graph.runs[r].rank.value != 1);
    if (!lanes.of_run[r]) continue;
    EXPECT_EQ(lanes.lanes.at(*lanes.of_run[r]).rank, run.graph.runs[r].rank);
    ++shown;
  }
  EXPECT_LT(shown, run.graph.runs.size());
}

TEST(Lanes, OfNothingAreNone) { EXPECT_TRUE(lanes_of({}, {}, 0).lanes.empty()); }

}  // namespace
}  // namespace weft::report::lanes_test

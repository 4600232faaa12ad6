// The profile's figures come from the run and add up.
#include "tools/report/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "engine/json/json.h"
#include "graph/dataflow/dump/critical_path.h"
#include "graph/dataflow/dump/graph_json.h"
#include "tests/tools/report/sample_run.h"
#include "tools/report/operations.h"
#include "tools/report/report_page.h"

namespace weft::report::profile_test {
namespace {

using Json = nlohmann::ordered_json;
using weft::testing::sample_run;
using weft::testing::SampleRun;

const SampleRun& sample() {
  static const SampleRun run =
      sample_run({.subdomains = 14, .ranks = 3, .workers = 2, .rounds = 3, .seed = 4}, 4);
  return run;
}

TEST(Operations, KnowEveryNodeOfTheSubdomainsGraph) {
  for (const auto& node : sample().graph.description.nodes)
    EXPECT_NE(operation_of_node(node.name), kMisc) << node.name;
  EXPECT_EQ(operation_of_node("something else"), kMisc);
  EXPECT_EQ(kOperations[operation_of_node("adapt shifted")], "MII adaptation");
  EXPECT_EQ(kOperations[kIdle], "idle");
  EXPECT_EQ(kOperations[kMisc], "misc");
  EXPECT_EQ(kOperations[kConversion], "conversion");
}

TEST(Operations, AddUpToTheWorkersTime) {
  for (const engine::RankSummary& rank : sample().simulated.summary.ranks) {
    double sum = 0;
    for (const double seconds : seconds_of_rank(rank, sample().graph)) sum += seconds;
    EXPECT_NEAR(sum, rank.workers * rank.wall, 1e-6 * sum);
  }
}

TEST(Operations, WhatANodeDoesBesideTakesNoMoreThanItsTime) {
  OperationSeconds seconds{};
  add_seconds("adapt interior", 1, {0.75, 0.5}, seconds);
  EXPECT_EQ(seconds[kInterfaceRefinement], 0.75);
  EXPECT_EQ(seconds[kChecks], 0.25);
  EXPECT_EQ(seconds[kInteriorAdaptation], 0);
}

TEST(Operations, OfARunWithoutAGraphAreMisc) {
  const engine::RankSummary& rank = sample().simulated.summary.ranks[0];
  const OperationSeconds seconds = seconds_of_rank(rank, {});
  EXPECT_DOUBLE_EQ(seconds[kMisc], rank.times.compute);
  EXPECT_DOUBLE_EQ(seconds[0], 0);
}

TEST(Operations, WhatWorkersWaitForSharedCoresIsIdle) {
  engine::RankSummary rank;
  rank.times.compute = 5;
  rank.times.idle = 1;
  OperationSeconds real{}, simulated{};
  add_beside_nodes(rank, 1.5, real);
  EXPECT_DOUBLE_EQ(real[kMisc], 3.5);
  EXPECT_DOUBLE_EQ(real[kIdle], 1);
  rank.counters["core_wait_seconds"] = 3;
  add_beside_nodes(rank, 1.5, simulated);
  EXPECT_DOUBLE_EQ(simulated[kMisc], 0.5);
  EXPECT_DOUBLE_EQ(simulated[kIdle], 4);
}

TEST(Profile, HasTheRunsOfTheGraphInTheRowsOfTheTimeline) {
  const Json& profile = sample().profile;
  EXPECT_EQ(profile["graph"], graph::dataflow::json_of(sample().graph));
  EXPECT_EQ(profile["timeline"]["of_run"].size(), sample().graph.runs.size());
  EXPECT_EQ(profile["uses_left_out"], 0);
  for (std::size_t r = 0; r < sample().graph.runs.size(); ++r) {
    const std::size_t lane = profile["timeline"]["of_run"][r];
    EXPECT_EQ(profile["timeline"]["lanes"][lane]["rank"], sample().graph.runs[r].rank.value);
  }
}

TEST(Profile, LeavesOutTheSmallestUsesButNoneOfTheCriticalPath) {
  const ProfileInput input{.report = sample().profile["report"], .graph = &sample().graph};
  const Json profile = profile_json(input, {.most_runs = 100'000, .most_uses = 20, .most_waits = 5});
  const graph::dataflow::GraphDump shown = graph::dataflow::dump_from_json(profile["graph"]);
  EXPECT_EQ(shown.uses.size() + profile["uses_left_out"].get<std::size_t>(), sample().graph.uses.size());
  EXPECT_LT(shown.uses.size(), sample().graph.uses.size());
  EXPECT_EQ(shown.critical_path.steps.size(), sample().graph.critical_path.steps.size());
  for (std::size_t i = 1; i < shown.critical_path.steps.size(); ++i) {
    const auto& step = shown.critical_path.steps[i];
    if (step.arrived_by) {
      EXPECT_EQ(shown.uses[*step.arrived_by].to, step.run);
    }
  }
  std::uint64_t largest = 0;
  for (const auto& use : sample().graph.uses) largest = std::max(largest, use.bytes);
  EXPECT_TRUE(
      std::any_of(shown.uses.begin(), shown.uses.end(), [&](const auto& u) { return u.bytes == largest; }));
  EXPECT_EQ(profile["waiting"]["subdomains"].size(), 5u);
}

TEST(Profile, LeavesOutAGraphOfTooManyRunsButKeepsItsSums) {
  const ProfileInput input{.report = sample().profile["report"], .graph = &sample().graph};
  const Json profile = profile_json(input, {.most_runs = 10});
  EXPECT_TRUE(profile["graph"].is_null());
  EXPECT_TRUE(profile["timeline"].is_null());
  EXPECT_EQ(profile["critical_path"], sample().profile["critical_path"]);
  EXPECT_EQ(profile["convergence"], sample().profile["convergence"]);
}

TEST(Profile, SumsWaitsByRankAndBySubdomainAlike) {
  double of_ranks = 0, of_subdomains = 0, all = 0;
  for (const auto& wait : graph::dataflow::waits_of(sample().graph))
    all += 1e-9 * static_cast<double>(wait.waited);
  for (const Json& wait : sample().profile["waiting"]["ranks"]) of_ranks += wait["seconds"].get<double>();
  for (const Json& wait : sample().profile["waiting"]["subdomains"])
    of_subdomains += wait["seconds"].get<double>();
  EXPECT_GT(all, 0);
  EXPECT_NEAR(of_ranks, all, 1e-9);
  EXPECT_NEAR(of_subdomains, all, 1e-9);
}

/// The sum of a counter over some runs.
template <class Wanted>
double sum_of(const std::string& counter, const Wanted& wanted) {
  const graph::dataflow::GraphDump& graph = sample().graph;
  const auto name = std::find(graph.counter_names.begin(), graph.counter_names.end(), counter);
  const auto place = static_cast<std::size_t>(name - graph.counter_names.begin());
  double sum = 0;
  for (const auto& run : graph.runs)
    if (wanted(run) && place < run.counters.size()) sum += run.counters[place];
  return sum;
}

TEST(Profile, SumsWhatNodesHaveDoneInARound) {
  for (const Json& round : sample().profile["convergence"]) {
    EXPECT_FALSE(round["counters"].contains("tets, interior"));
    const auto in_round = [&](const auto& run) { return run.round == round["round"]; };
    for (const auto& [name, value] : round["counters"].items())
      EXPECT_NEAR(value.get<double>(), sum_of(name, in_round), 1e-6) << name;
  }
}

TEST(Profile, WhatIsLeftIsThatOfTheWholeMeshAfterEachStep) {
  const Json& left = sample().profile["left"];
  ASSERT_GE(left.size(), 3u);
  const auto node_of = [](const auto& run) { return sample().graph.description.nodes[run.node].name; };
  const auto interior = [&](const auto& run) { return node_of(run) == "adapt interior"; };
  EXPECT_EQ(left[0]["step"], 0);
  EXPECT_EQ(left[0]["subdomains"], 14);
  EXPECT_DOUBLE_EQ(left[0]["interface"]["poor tets"].get<double>(), sum_of("poor tets, interface", interior));
  EXPECT_GT(left[0]["interface"]["poor tets"].get<double>(), left[1]["interface"]["poor tets"].get<double>());
  for (const Json& step : left)  // whoever has done nothing in a step still counts: no tets get lost
    EXPECT_EQ(step["interior"]["tets"], left[0]["interior"]["tets"]) << step["step"];
}

graph::dataflow::NodeIndex node_named(const char* name, const graph::dataflow::GraphDump& graph) {
  const auto& nodes = graph.description.nodes;
  return static_cast<graph::dataflow::NodeIndex>(
      std::ranges::find(nodes, name, &graph::dataflow::NodeDescription::name) - nodes.begin());
}

TEST(Profile, SubdomainsThatRestKeepWhatTheyCountedLast) {
  graph::dataflow::GraphDump graph = sample().graph;
  const Json before = sample().profile["left"];
  const auto rests = [&](const auto& run) {
    return run.instance == 3 && run.round > 0 && graph.description.nodes[run.node].name == "adapt shifted";
  };
  for (auto& run : graph.runs)
    if (rests(run)) run.node = node_named("propose", graph);  // as if it had not adapted
  const Json after = profile_json({.report = sample().profile["report"], .graph = &graph})["left"];
  EXPECT_EQ(after[1], before[1]);
  EXPECT_EQ(after[2]["subdomains"], before[2]["subdomains"].get<int>() - 1);
  EXPECT_EQ(after[2]["interior"]["tets"], before[2]["interior"]["tets"]);
  EXPECT_GT(after[2]["interface"]["poor tets"], before[2]["interface"]["poor tets"]);
}

TEST(Profile, ASecondPhaseIsToldFromShifts) {
  graph::dataflow::GraphDump graph = sample().graph;
  for (auto& run : graph.runs)  // as if nothing had been adapted after the second shift but all, in the third
    if (run.round == 1 && run.node == node_named("adapt shifted", graph))
      run.node = node_named("adapt interior", graph), run.round = 2;
  Json expected = sample().profile["left"];
  for (std::size_t s = 0; s < expected.size(); ++s) EXPECT_EQ(expected[s]["everything"], s == 0);
  expected[2]["everything"] = true;
  EXPECT_EQ(profile_json({.report = sample().profile["report"], .graph = &graph})["left"], expected);
}

TEST(Profile, OfAPlainRunHasNothingThatWasNotRecorded) {
  const Json profile = profile_json({.report = sample().profile["report"]});
  for (const char* name :
       {"total", "engine", "waiting", "critical_path", "graph", "timeline", "mesh", "case"})
    EXPECT_TRUE(profile[name].is_null()) << name;
  for (const char* name :
       {"ranks", "convergence", "left", "memory", "hardware", "published", "published_curves"})
    EXPECT_TRUE(profile[name].empty()) << name;
}

TEST(ReportPage, IsFilledIn) {  // report_page_test.py looks into it
  EXPECT_THAT(report_page(sample().profile), ::testing::Not(::testing::HasSubstr("{{")));
}

TEST(ReportPage, WithoutAMeshHasNoThreeJs) {
  const std::string with = report_page(sample().profile);
  const std::string without = report_page(profile_json({.report = sample().profile["report"]}));
  EXPECT_GT(with.size(), without.size() + 500'000);
}

TEST(ReportPage, IsOfProfilesOnly) {
  EXPECT_THROW(report_page(sample().profile["graph"]), std::invalid_argument);
  EXPECT_THROW(report_page(Json::array()), std::invalid_argument);
}

}  // namespace
}  // namespace weft::report::profile_test

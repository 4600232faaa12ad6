// The profile's figures come from the run and add up.
#include "tools/report/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "graph/dataflow/critical_path.h"
#include "graph/dataflow/graph_json.h"
#include "tests/tools/report/sample_run.h"
#include "tools/report/operations.h"
#include "tools/report/report_page.h"

namespace weft::report {
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

TEST(Operations, OfARunWithoutAGraphAreMisc) {
  const engine::RankSummary& rank = sample().simulated.summary.ranks[0];
  const OperationSeconds seconds = seconds_of_rank(rank, {});
  EXPECT_DOUBLE_EQ(seconds[kMisc], rank.times.compute);
  EXPECT_DOUBLE_EQ(seconds[0], 0);
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

TEST(Profile, CountsWhatASubdomainCountsTwiceInARoundOnce) {
  double tets = 0;
  std::set<std::uint64_t> seen;
  for (auto run = sample().graph.runs.rbegin(); run != sample().graph.runs.rend(); ++run)
    if (run->round == 0 && !run->counters.empty() && run->counters[0] > 0 &&
        seen.insert(run->instance).second)
      tets += run->counters[0];
  EXPECT_EQ(seen.size(), 14u);
  EXPECT_NEAR(sample().profile["convergence"][0]["counters"]["tets"].get<double>(), tets, 1e-6 * tets);
}

TEST(Profile, OfAPlainRunHasNothingThatWasNotRecorded) {
  const Json profile = profile_json({.report = sample().profile["report"]});
  for (const char* name :
       {"total", "engine", "waiting", "critical_path", "graph", "timeline", "mesh", "case"})
    EXPECT_TRUE(profile[name].is_null()) << name;
  for (const char* name : {"ranks", "convergence", "memory", "hardware", "published"})
    EXPECT_TRUE(profile[name].empty()) << name;
}

TEST(ReportPage, HoldsTheDocumentAndNoEndOfItsScript) {
  const std::string page = report_page(sample().profile);
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.find(open) + open.size(), end = page.find("</script>", begin);
  ASSERT_NE(page.find(open), std::string::npos);
  EXPECT_EQ(Json::parse(page.substr(begin, end - begin)), sample().profile);
  EXPECT_THAT(page, ::testing::Not(::testing::HasSubstr("{{")));
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
}  // namespace weft::report

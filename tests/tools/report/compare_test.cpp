// Differences of two runs are those that were made.
#include "tools/report/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/json/json.h"
#include "tests/tools/report/sample_run.h"

namespace weft::report::compare_test {
namespace {

using Json = nlohmann::ordered_json;

const Json& sample() {
  static const Json profile =
      weft::testing::sample_run({.subdomains = 8, .ranks = 2, .workers = 2, .rounds = 2}, 4).profile;
  return profile;
}

const ComparedSeconds& row(const std::vector<ComparedSeconds>& rows, const std::string& name) {
  for (const ComparedSeconds& r : rows)
    if (r.name == name) return r;
  throw std::out_of_range(name);
}

TEST(Compare, FindsTheOperationThatGotSlower) {
  Json slower = sample();
  slower["report"]["seconds"]["adapt"] = sample()["report"]["seconds"]["adapt"].get<double>() + 3;
  slower["total"]["seconds"]["gather"] = sample()["total"]["seconds"]["gather"].get<double>() + 5;
  slower["ranks"][1]["seconds"]["gather"] = sample()["ranks"][1]["seconds"]["gather"].get<double>() + 5;
  slower["ranks"][1]["seconds"]["idle"] = 100.0;
  const Comparison comparison = compare("a", sample(), "b", slower);
  EXPECT_NEAR(comparison.b.seconds - comparison.a.seconds, 3, 1e-12);
  EXPECT_NEAR(row(comparison.operations, "gather").b - row(comparison.operations, "gather").a, 5, 1e-9);
  EXPECT_NEAR(row(comparison.ranks, "rank 1").b - row(comparison.ranks, "rank 1").a, 5, 1e-9);
  EXPECT_NEAR(row(comparison.ranks, "rank 0").b - row(comparison.ranks, "rank 0").a, 0, 1e-9);
  EXPECT_THAT(comparison.verdict(),
              ::testing::AllOf(::testing::HasSubstr("slower"), ::testing::HasSubstr("most of it is gather")));
  const Comparison back = compare("b", slower, "a", sample());
  EXPECT_THAT(back.verdict(),
              ::testing::AllOf(::testing::HasSubstr("faster"), ::testing::HasSubstr("most of it is gather")));
  const std::string text = comparison_text(comparison);
  EXPECT_LT(text.find("gather"), text.find("scatter"));  // the largest difference first
}

TEST(Compare, JudgesQuality) {
  Json worse = sample();
  worse["report"]["after"]["quality"]["mean"] = 0.1;
  worse["report"]["after"]["edge_length"]["share_long"] = 0.0;
  const std::string text = comparison_text(compare("a", sample(), "b", worse));
  EXPECT_THAT(text, ::testing::ContainsRegex("quality, mean .* 0.1  worse"));
  EXPECT_THAT(text, ::testing::ContainsRegex("edges long .* 0.00 %  better"));
}

TEST(Compare, RemarksOnWhatMakesRunsHardToCompare) {
  EXPECT_TRUE(compare("a", sample(), "b", sample()).remarks.empty());
  Json other = sample();
  other["report"]["output"]["tets"] = 1;
  other["report"]["input"]["tets"] = 1;
  other["report"]["goal_met"] = false;
  other["ranks"].erase(1);
  EXPECT_EQ(compare("a", sample(), "b", other).remarks.size(), 4u);
}

TEST(Compare, TakesPlainReportsWithoutOperations) {
  const Comparison comparison = compare("a", sample()["report"], "b", sample());
  EXPECT_TRUE(comparison.operations.empty());
  EXPECT_TRUE(comparison.ranks.empty());
  EXPECT_FALSE(comparison.steps.empty());
  EXPECT_THAT(comparison.verdict(), ::testing::HasSubstr("as fast as"));
  EXPECT_THROW(compare("a", sample()["graph"], "b", sample()), std::invalid_argument);
  EXPECT_THROW(compare("a", sample(), "b", Json(3)), std::invalid_argument);
}

TEST(Compare, IsTheSameAsJson) {
  const Comparison comparison = compare("a", sample(), "b", sample());
  const Json json = comparison_json(comparison);
  EXPECT_EQ(json["operations"].size(), comparison.operations.size());
  EXPECT_EQ(json["measures"].size(), comparison.measures.size());
  EXPECT_EQ(json["verdict"], comparison.verdict());
}

}  // namespace
}  // namespace weft::report::compare_test

// Small parts: base64, hardware, published figures, assets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "engine/json/json.h"
#include "tools/report/assets.h"
#include "tools/report/encode/base64.h"
#include "tools/report/hardware.h"
#include "tools/report/memory_sampler.h"
#include "tools/report/published.h"

namespace weft::report::parts_test {
namespace {

std::string base64_of_text(const std::string& text) { return base64_of(text); }

TEST(Base64, AgreesWithTheStandard) {  // RFC 4648, section 10
  EXPECT_EQ(base64_of_text(""), "");
  EXPECT_EQ(base64_of_text("f"), "Zg==");
  EXPECT_EQ(base64_of_text("fo"), "Zm8=");
  EXPECT_EQ(base64_of_text("foo"), "Zm9v");
  EXPECT_EQ(base64_of_text("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of(std::vector<std::uint16_t>{0xFFFF, 1}), "//8BAA==");
}

TEST(Hardware, OfThisMachineHasCoresAndMemory) {
  const Hardware machine = this_machine(3);
  EXPECT_THAT(machine.ranks, ::testing::ElementsAre(3));
  EXPECT_GE(machine.cores, 1);
  EXPECT_GT(machine.memory, 100'000'000u);
}

TEST(Hardware, IsToldOnceForRanksThatHaveTheSame) {
  const std::vector<Hardware> kinds =
      merge({{{0}, "A", 4, 8}, {{1}, "B", 4, 8}, {{2}, "A", 4, 8}, {{3}, "A", 2, 8}});
  ASSERT_EQ(kinds.size(), 3u);
  EXPECT_THAT(kinds[0].ranks, ::testing::ElementsAre(0, 2));
  EXPECT_THAT(kinds[1].ranks, ::testing::ElementsAre(1));
  EXPECT_THAT(kinds[2].ranks, ::testing::ElementsAre(3));
}

TEST(Published, FiguresAreOfNamedCasesAndHaveSources) {
  EXPECT_TRUE(published_runs("").empty());
  EXPECT_TRUE(published_runs("cube").empty());
  EXPECT_EQ(published_cases().size(), 3u);
  for (const std::string_view name : published_cases()) {
    EXPECT_GE(published_runs(name).size(), 4u);
    for (const PublishedRun& run : published_runs(name)) {
      EXPECT_FALSE(run.source.empty());
      EXPECT_GE(run.cores, 1);
      for (const auto& share : {run.quality_mean, run.quality_q01, run.quality_min, run.unit_edges}) {
        ASSERT_TRUE(share.has_value());
        EXPECT_GT(*share, 0);
        EXPECT_LT(*share, 1);
      }
      EXPECT_LT(*run.quality_min, *run.quality_q01 + 1e-9);
      EXPECT_LT(*run.quality_q01, *run.quality_mean);
    }
  }
}

TEST(Published, CurvesAreDensitiesThatAgreeWithTheFigures) {
  EXPECT_TRUE(published_curves("").empty());
  EXPECT_TRUE(published_curves("case").empty()) << "the head of the table is no curve";
  std::set<std::string> programs;
  for (const std::string_view name : {"cube-polar2-500000", "delta-wing-500000"}) {
    for (const PublishedCurve& curve : published_curves(name)) {
      programs.insert(curve.program);
      ASSERT_EQ(curve.edges.size(), curve.densities.size() + 1);
      double all = 0, first_moment = 0;
      for (std::size_t i = 0; i < curve.densities.size(); ++i) {
        ASSERT_LT(curve.edges[i], curve.edges[i + 1]);
        const double share = curve.densities[i] * (curve.edges[i + 1] - curve.edges[i]);
        all += share, first_moment += share * 0.5 * (curve.edges[i] + curve.edges[i + 1]);
      }
      EXPECT_NEAR(all, 1, 2e-3) << curve.program << ' ' << curve.measure;
      for (const PublishedRun& run : published_runs(name)) {
        if (run.program != curve.program || run.cores != curve.cores || curve.measure != "mean_ratio")
          continue;
        EXPECT_NEAR(first_moment, *run.quality_mean, 2e-3) << curve.program << ' ' << curve.cores;
      }
    }
  }
  EXPECT_EQ(programs, (std::set<std::string>{"CDT3D", "EPIC", "feflo.a", "refine"}));
}

TEST(MemorySampler, SeesMemoryThatIsTaken) {
  MemorySampler sampler(2, std::chrono::milliseconds(1));
  constexpr std::size_t kTaken = 80'000'000;
  const std::vector<char> taken(kTaken, 1);
  const MemorySamples samples = sampler.stop();
  EXPECT_EQ(samples.rank, 2);
  ASSERT_GE(samples.bytes.size(), 2u);
  EXPECT_EQ(samples.seconds.size(), samples.bytes.size());
  EXPECT_TRUE(std::is_sorted(samples.seconds.begin(), samples.seconds.end()));
  EXPECT_GE(samples.bytes.back(), kTaken);
  EXPECT_EQ(sampler.stop().bytes, samples.bytes);
}

TEST(MemorySampler, KeepsAThousandSamplesAtMost) {
  MemorySampler sampler(0, std::chrono::milliseconds(0));
  const std::uint64_t calls = 3000;
  for (std::uint64_t i = 0; i < calls; ++i) resident_bytes();  // takes as long as so many samples
  EXPECT_LE(sampler.stop().bytes.size(), 1000u);
}

TEST(Assets, AreThereByName) {
  EXPECT_THAT(std::string(asset("style.css")), ::testing::HasSubstr("--ground"));
  EXPECT_THAT(std::string(asset("chart.min.js")), ::testing::HasSubstr("Chart.js v"));
  EXPECT_GT(asset("three.min.js").size(), 400'000u);
  EXPECT_TRUE(asset("other.js").empty());
}

}  // namespace
}  // namespace weft::report::parts_test

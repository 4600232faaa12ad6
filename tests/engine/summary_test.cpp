// Summaries: from traces, of all ranks, as JSON, through a payload.
#include "engine/trace/summary.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "engine/base/serialize.h"
#include "engine/json/json.h"

namespace weft::engine::summary_test {
namespace {

constexpr TimePoint kSecond = 1'000'000'000;

Span span_of(Activity activity, std::uint32_t method, TimePoint seconds) {
  return {0, seconds * kSecond, ObjectId{Rank(0), 1}, method, activity, 0};
}

RunFacts facts_of(double wall, std::vector<std::string> method_names = {}) {
  RunFacts facts;
  facts.wall = wall;
  facts.method_names = std::move(method_names);
  return facts;
}

/// Rank `rank` of two with two workers, which computed `seconds` each and sent the other rank 100 bytes.
RankSummary sample_rank(int rank, TimePoint seconds, double wall) {
  Trace trace(Rank(rank), 2, 2);
  for (int i = 0; i < 2; ++i) trace.worker_lane(i).span(span_of(Activity::compute, 0, seconds));
  trace.communication_lane().sent(Traffic::invoke, 0, Rank(1 - rank), 100);
  trace.communication_lane().received(Traffic::invoke, 0, Rank(1 - rank), 100);
  RunFacts facts = facts_of(wall, {"Part::refine"});
  facts.network_calls = {{"MPI_Isend", 3}, {"MPI_Barrier", 1}};
  facts.collective_calls = 1;
  facts.counters = {{"steals", 2.0 + rank}};
  return summarize(trace, facts);
}

TEST(RankSummary, WorkersAreIdleWhenTheyNeitherComputeNorUnpackNorCopy) {
  Trace trace(Rank(0), 1, 2);
  trace.worker_lane(0).span(span_of(Activity::compute, 0, 3));
  trace.worker_lane(0).span(span_of(Activity::unpack, 0, 1));
  trace.worker_lane(1).span(span_of(Activity::compute, 0, 2));
  trace.worker_lane(1).span(span_of(Activity::pack, Span::kNoName, 3));  // for a snapshot
  trace.communication_lane().span(span_of(Activity::pack, 0, 1));
  trace.communication_lane().span(span_of(Activity::communicate, Span::kNoName, 7));
  RunFacts facts = facts_of(10);
  facts.communication = 4;
  const RankSummary summary = summarize(trace, facts);
  EXPECT_DOUBLE_EQ(summary.times.compute, 5);
  EXPECT_DOUBLE_EQ(summary.times.unpack, 1);
  EXPECT_DOUBLE_EQ(summary.times.copy, 3);
  EXPECT_DOUBLE_EQ(summary.times.idle, 2 * 10 - 5 - 1 - 3);
  EXPECT_DOUBLE_EQ(summary.times.pack, 1);
  EXPECT_DOUBLE_EQ(summary.times.communication, 4);
  EXPECT_EQ(summary.worker_compute, (std::vector<double>{3, 2}));
}

TEST(RankSummary, HelpersTakeOffIdleTime) {
  Trace trace(Rank(0), 1, 2, {}, 2);
  trace.worker_lane(0).span(span_of(Activity::compute, 0, 8));
  trace.helper_lane(0).span(span_of(Activity::help, Span::kNoName, 3));
  trace.helper_lane(1).span(span_of(Activity::help, Span::kNoName, 2));
  const RankSummary summary = summarize(trace, facts_of(10));
  EXPECT_EQ(summary.workers, 2);
  EXPECT_DOUBLE_EQ(summary.times.compute, 8);
  EXPECT_DOUBLE_EQ(summary.times.help, 5);
  EXPECT_DOUBLE_EQ(summary.times.idle, 2 * 10 - 8 - 5);
  EXPECT_EQ(summary.worker_compute, (std::vector<double>{8, 0}));
  EXPECT_DOUBLE_EQ(merge({summary}).balance_saving, 1 - 13. / 2 / 10);
}

TEST(RankSummary, IdleTimeIsNeverNegative) {
  Trace trace(Rank(0), 1, 1);
  trace.worker_lane(0).span(span_of(Activity::compute, 0, 3));
  EXPECT_EQ(summarize(trace, facts_of(2.5)).times.idle, 0);
}

TEST(RankSummary, ListsTheMethodsThatRanOrHadMessages) {
  Trace trace(Rank(0), 2, 2);
  trace.worker_lane(0).span(span_of(Activity::compute, 0, 3));
  trace.worker_lane(1).span(span_of(Activity::compute, 0, 5));
  trace.worker_lane(1).span(span_of(Activity::compute, 3, 1));
  trace.communication_lane().sent(Traffic::invoke, 2, Rank(1), 7);
  trace.communication_lane().sent(Traffic::migrate, Span::kNoName, Rank(1), 9);
  const auto methods = summarize(trace, facts_of(10, {"a", "b", "c"})).methods;
  ASSERT_EQ(methods.size(), 4u);
  EXPECT_EQ(methods[0].name, "a");
  EXPECT_EQ(methods[0].count, 2u);
  EXPECT_DOUBLE_EQ(methods[0].seconds, 8);
  EXPECT_DOUBLE_EQ(methods[0].longest, 5);
  EXPECT_EQ(methods[1].name, "c");
  EXPECT_EQ(methods[1].volume.sent.bytes, 7u);
  EXPECT_EQ(methods[2].name, "method 3") << "the registry's names are too few";
  EXPECT_EQ(methods[3].name, "") << "the engine's own messages";
  EXPECT_EQ(methods[3].volume.sent.bytes, 9u);
}

TEST(RankSummary, CountsMigrationsByTheirMessages) {
  Trace trace(Rank(0), 2, 1);
  trace.communication_lane().sent(Traffic::migrate, Span::kNoName, Rank(1), 500);
  trace.communication_lane().received(Traffic::migrate, Span::kNoName, Rank(1), 30);
  trace.communication_lane().received(Traffic::migrate, Span::kNoName, Rank(1), 40);
  const RankSummary summary = summarize(trace, {});
  EXPECT_EQ(summary.migrations().sent.messages, 1u);
  EXPECT_EQ(summary.migrations().received.messages, 2u);
  EXPECT_EQ(summary.migrations().received.bytes, 70u);
  ASSERT_EQ(summary.peers.size(), 1u);
  EXPECT_EQ(summary.peers[0].rank, Rank(1));
}

TEST(RankSummary, KnowsThePeakMemoryAndTheDroppedSpans) {
  Trace trace(Rank(0), 1, 1, {.spans = true, .max_spans_per_lane = 1});
  for (int i = 0; i < 3; ++i) trace.worker_lane(0).span(span_of(Activity::compute, 0, 1));
  const RankSummary summary = summarize(trace, {});
  EXPECT_GT(summary.peak_rss, 1u << 20);
  EXPECT_EQ(summary.dropped_spans, 2u);
}

TEST(RankSummary, TravelsInAPayload) {
  RankSummary before = sample_rank(1, 3, 4);
  Packer packer(true);
  RankSummary copy = before;
  packer(copy);
  RankSummary after;
  Unpacker unpacker(packer.take());
  unpacker(after);
  unpacker.finish();
  EXPECT_EQ(json_of(after), json_of(before));
  EXPECT_EQ(after.methods.at(0).name, "Part::refine");
}

TEST(RunSummary, AddsUpTheRanks) {
  const RunSummary run = merge({sample_rank(1, 3, 10), sample_rank(0, 1, 8)});
  EXPECT_EQ(run.workers, 4);
  EXPECT_DOUBLE_EQ(run.wall, 10);
  EXPECT_DOUBLE_EQ(run.times.compute, 8);
  ASSERT_EQ(run.methods.size(), 1u);
  EXPECT_EQ(run.methods[0].count, 4u);
  EXPECT_DOUBLE_EQ(run.methods[0].longest, 3);
  EXPECT_EQ(run.methods[0].volume.sent.bytes, 200u);
  EXPECT_EQ(run.network_calls.at("MPI_Isend"), 6);
  EXPECT_EQ(run.collective_calls, 2);
  EXPECT_DOUBLE_EQ(run.counters.at("steals").sum, 5);
  EXPECT_DOUBLE_EQ(run.counters.at("steals").min, 2);
  EXPECT_DOUBLE_EQ(run.counters.at("steals").max, 3);
  EXPECT_EQ(run.ranks[0].rank, Rank(0)) << "sorted by rank";
}

TEST(RunSummary, FindsTheImbalanceAndWhatPerfectBalanceWouldSave) {
  const RunSummary run = merge({sample_rank(0, 1, 4), sample_rank(1, 3, 4)});
  EXPECT_DOUBLE_EQ(run.load_imbalance, 1.5);  // 3 s a worker where the mean is 2
  EXPECT_DOUBLE_EQ(run.idle_share, 0.5);      // 8 of 16 worker seconds
  EXPECT_DOUBLE_EQ(run.balance_saving, 0.5);  // 2 s would do instead of 4
  EXPECT_EQ(run.verdict(), "perfect balance would save 50 % of 4 s");
}

TEST(RunSummary, ARankWithFewerWorkersIsBalancedWhenItComputesLess) {
  RankSummary small = sample_rank(0, 2, 2);
  RankSummary large = sample_rank(1, 2, 2);
  small.workers = 1;
  small.times.compute = 2;
  EXPECT_DOUBLE_EQ(merge({small, large}).load_imbalance, 1);
}

TEST(RunSummary, SeesMessagesThatWereLost) {
  RankSummary a = sample_rank(0, 1, 1), b = sample_rank(1, 1, 1);
  EXPECT_TRUE(merge({a, b}).consistent.messages && merge({a, b}).consistent.bytes &&
              merge({a, b}).consistent.pairs);
  b.traffic[0].received.bytes -= 1;
  EXPECT_TRUE(merge({a, b}).consistent.messages);
  EXPECT_FALSE(merge({a, b}).consistent.bytes);
  b.traffic[0].received.messages -= 1;
  EXPECT_FALSE(merge({a, b}).consistent.messages);
}

TEST(RunSummary, SeesMessagesThatReachedTheWrongRankThoughTheTotalsAgree) {
  RankSummary a = sample_rank(0, 1, 1), b = sample_rank(1, 1, 1);
  b.peers.at(0).rank = Rank(1);
  const RunSummary run = merge({a, b});
  EXPECT_TRUE(run.consistent.bytes);
  EXPECT_FALSE(run.consistent.pairs);
}

TEST(RunSummary, OfNoRankOrNoTimeIsFinite) {
  const RunSummary none = merge({});
  EXPECT_EQ(none.balance_saving, 0);
  EXPECT_EQ(none.load_imbalance, 1);
  const RunSummary still = merge({RankSummary{}});
  EXPECT_EQ(still.balance_saving, 0);
  EXPECT_EQ(still.idle_share, 0);
  EXPECT_EQ(json_of(still).dump().find("null"), std::string::npos);
}

TEST(RunSummary, ItsJsonHasWhatTheHeaderSays) {
  const auto json =
      nlohmann::json::parse(json_of(merge({sample_rank(0, 1, 4), sample_rank(1, 3, 4)})).dump());
  EXPECT_EQ(json["schema"], "weft-engine-1");
  EXPECT_EQ(json["ranks"], 2);
  for (const char* field :
       {"workers", "wall", "compute", "unpack", "copy", "help", "idle", "pack", "communication",
        "load_imbalance", "idle_share", "balance_saving", "collective_calls", "dropped_spans"}) {
    EXPECT_TRUE(json[field].is_number()) << field;
  }
  EXPECT_EQ(json["methods"][0]["name"], "Part::refine");
  EXPECT_EQ(json["methods"][0]["sent"]["bytes"], 200);
  EXPECT_EQ(json["traffic"]["invoke"]["received"]["messages"], 2);
  EXPECT_EQ(json["network_calls"]["MPI_Barrier"], 2);
  EXPECT_EQ(json["counters"]["steals"]["max"], 3);
  EXPECT_EQ(json["consistent"]["pairs"], true);
  EXPECT_TRUE(json["peak_rss"]["sum"].is_number_integer());
  const auto& rank = json["per_rank"][1];
  EXPECT_EQ(rank["rank"], 1);
  EXPECT_EQ(rank["worker_compute"], nlohmann::json::array({3.0, 3.0}));
  EXPECT_EQ(rank["peers"][0]["rank"], 0);
  EXPECT_EQ(rank["network_calls"]["MPI_Isend"], 3);
}

}  // namespace
}  // namespace weft::engine::summary_test

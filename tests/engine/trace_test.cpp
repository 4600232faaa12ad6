// Lanes: what is counted, what is kept, and that lanes do not disturb each other.
#include "engine/trace/trace.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace weft::engine::trace_test {
namespace {

Span compute(std::uint32_t method, TimePoint begin, TimePoint end) {
  return {begin, end, ObjectId{Rank(0), 1}, method, Activity::compute, 0};
}

TEST(Trace, HasALaneForCommunicationAndOneForEachWorker) {
  Trace trace(Rank(2), 4, 3);
  EXPECT_EQ(trace.rank(), Rank(2));
  EXPECT_EQ(trace.ranks(), 4);
  EXPECT_EQ(trace.workers(), 3);
  ASSERT_EQ(trace.lanes().size(), 4u);
  EXPECT_EQ(&trace.communication_lane(), &trace.lanes()[0]);
  EXPECT_EQ(&trace.worker_lane(2), &trace.lanes()[3]);
}

TEST(Trace, LanesShareNoCacheLine) {
  const Trace trace(Rank(0), 1, 2);
  static_assert(sizeof(Lane) % 64 == 0);
  for (const Lane& lane : trace.lanes()) EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&lane) % 64, 0u);
}

TEST(Trace, EveryActivityAndTrafficHasItsName) {
  EXPECT_STREQ(name_of(Activity::compute), "compute");
  EXPECT_STREQ(name_of(Activity::communicate), "communicate");
  EXPECT_STREQ(name_of(Traffic::invoke), "invoke");
  EXPECT_STREQ(name_of(Traffic::forward), "forward");
}

TEST(Lane, AddsUpTheTimeOfEachActivity) {
  Lane lane(1, {});
  lane.span(compute(0, 100, 150));
  lane.span(compute(1, 200, 210));
  lane.span({300, 307, {}, Span::kNoName, Activity::pack, 0});
  EXPECT_EQ(lane.time(Activity::compute).count, 2u);
  EXPECT_EQ(lane.time(Activity::compute).total, 60);
  EXPECT_EQ(lane.time(Activity::pack).total, 7);
  EXPECT_EQ(lane.time(Activity::unpack).count, 0u);
}

TEST(Lane, KeepsTheLongestRunOfEachMethod) {
  Lane lane(1, {});
  lane.span(compute(3, 0, 10));
  lane.span(compute(3, 20, 50));
  lane.span(compute(3, 60, 65));
  EXPECT_EQ(lane.num_methods(), 4u);
  EXPECT_EQ(lane.compute_time(3).count, 3u);
  EXPECT_EQ(lane.compute_time(3).total, 45);
  EXPECT_EQ(lane.compute_time(3).longest, 30);
  EXPECT_EQ(lane.compute_time(0).count, 0u);
  EXPECT_EQ(lane.compute_time(99).count, 0u) << "never seen";
}

TEST(Lane, ComputationWithoutAMethodIsCountedApart) {
  Lane lane(1, {});
  lane.span(compute(Span::kNoName, 0, 5));
  lane.span(compute(0, 0, 7));
  EXPECT_EQ(lane.compute_time(Span::kNoName).total, 5);
  EXPECT_EQ(lane.compute_time(0).total, 7);
  EXPECT_EQ(lane.num_methods(), 1u);
}

TEST(Lane, UnpackingForAMethodIsNotThatMethodsComputation) {
  Lane lane(1, {});
  lane.span({0, 9, {}, 0, Activity::unpack, 0});
  EXPECT_EQ(lane.compute_time(0).count, 0u);
}

TEST(Lane, ASpanThatEndsBeforeItBeginsTakesNoTime) {
  Lane lane(1, {});
  lane.span(compute(0, 10, 4));
  EXPECT_EQ(lane.time(Activity::compute).total, 0);
  EXPECT_EQ(lane.compute_time(0).longest, 0);
}

TEST(Lane, CountsMessagesByTrafficMethodAndPeerInBothDirections) {
  Lane lane(3, {});
  lane.sent(Traffic::invoke, 0, Rank(1), 100);
  lane.sent(Traffic::invoke, 1, Rank(2), 10);
  lane.received(Traffic::migrate, Span::kNoName, Rank(1), 1000);
  EXPECT_EQ(lane.volume(Traffic::invoke).sent.messages, 2u);
  EXPECT_EQ(lane.volume(Traffic::invoke).sent.bytes, 110u);
  EXPECT_EQ(lane.volume(Traffic::invoke).received.messages, 0u);
  EXPECT_EQ(lane.volume(Traffic::migrate).received.bytes, 1000u);
  EXPECT_EQ(lane.volume(std::uint32_t{1}).sent.bytes, 10u);
  EXPECT_EQ(lane.volume(Span::kNoName).received.messages, 1u);
  EXPECT_EQ(lane.volume(Rank(1)).sent.bytes, 100u);
  EXPECT_EQ(lane.volume(Rank(1)).received.bytes, 1000u);
  EXPECT_EQ(lane.volume(Rank(0)).sent.messages, 0u);
}

TEST(Lane, AMessageOfNoRankCountsInTheTotals) {
  Lane lane(2, {});
  lane.sent(Traffic::forward, Span::kNoName, Rank(), 5);
  lane.sent(Traffic::forward, Span::kNoName, Rank(2), 5);
  EXPECT_EQ(lane.volume(Traffic::forward).sent.messages, 2u);
  EXPECT_EQ(lane.volume(Rank()).sent.messages, 0u);
  EXPECT_EQ(lane.volume(Rank(2)).sent.messages, 0u);
}

TEST(Lane, KeepsNoSpansUnlessAsked) {
  Lane lane(1, {});
  lane.span(compute(0, 0, 1));
  lane.departure({5, 1});
  EXPECT_EQ(lane.spans().size(), 0u);
  EXPECT_EQ(lane.departures().size(), 0u);
  EXPECT_EQ(lane.spans().dropped() + lane.departures().dropped(), 0u);
}

TEST(Lane, KeepsSpansAndDeparturesInTheirOrder) {
  Lane lane(1, {.spans = true});
  constexpr int kMany = 5000;  // several chunks
  for (int i = 0; i < kMany; ++i) {
    lane.span(compute(0, i, i + 1));
    lane.departure({i, static_cast<std::uint64_t>(i)});
  }
  const std::vector<Span> spans = lane.spans().copy();
  const std::vector<Departure> departures = lane.departures().copy();
  ASSERT_EQ(spans.size(), static_cast<std::size_t>(kMany));
  ASSERT_EQ(departures.size(), static_cast<std::size_t>(kMany));
  for (int i = 0; i < kMany; ++i) {
    EXPECT_EQ(spans[static_cast<std::size_t>(i)].begin, i);
    EXPECT_EQ(departures[static_cast<std::size_t>(i)].time, i);
  }
}

TEST(Lane, DropsAndCountsWhatComesAfterTheLimitButCountersGoOn) {
  Lane lane(1, {.spans = true, .max_spans_per_lane = 3});
  for (int i = 0; i < 10; ++i) {
    lane.span(compute(0, i, i + 1));
    lane.departure({i, 1});
  }
  EXPECT_EQ(lane.spans().size(), 3u);
  EXPECT_EQ(lane.spans().dropped(), 7u);
  EXPECT_EQ(lane.spans().copy().back().begin, 2);
  EXPECT_EQ(lane.departures().dropped(), 7u);
  EXPECT_EQ(lane.compute_time(0).count, 10u);
}

TEST(Lane, ALimitOfNothingKeepsNothing) {
  Lane lane(1, {.spans = true, .max_spans_per_lane = 0});
  lane.span(compute(0, 0, 1));
  EXPECT_TRUE(lane.spans().copy().empty());
  EXPECT_EQ(lane.spans().dropped(), 1u);
}

TEST(Trace, OfManyRanksSomeKeepSpansEvenlySpread) {
  for (const int ranks : {1, 2, 7, 8, 9, 160, 4096}) {
    const TraceOptions options{.spans = true, .most_ranks = 8};
    std::vector<int> keeping;
    for (int r = 0; r < ranks; ++r)
      if (Trace(Rank(r), ranks, 0, options).keeps_spans()) keeping.push_back(r);
    ASSERT_EQ(keeping.size(), static_cast<std::size_t>(std::min(ranks, 8)));
    EXPECT_EQ(keeping.front(), 0);
    keeping.push_back(ranks);
    for (std::size_t i = 1; i < keeping.size(); ++i)
      EXPECT_LE(keeping[i] - keeping[i - 1], (ranks + 7) / 8) << ranks;
  }
  Trace other(Rank(1), 9, 1, {.spans = true, .most_ranks = 1});
  other.worker_lane(0).span(compute(0, 0, 5));
  EXPECT_EQ(other.worker_lane(0).spans().size(), 0u);
  EXPECT_EQ(other.worker_lane(0).time(Activity::compute).total, 5) << "counters go on";
}

TEST(Trace, ThreadsRecordSideBySide) {  // for the thread sanitizer
  Trace trace(Rank(0), 2, 4, {.spans = true});
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&lane = trace.worker_lane(i), i] {
      for (int k = 0; k < 3000; ++k) lane.span(compute(static_cast<std::uint32_t>(k % 7), k, k + i));
      lane.sent(Traffic::invoke, 0, Rank(1), 8);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(trace.worker_lane(i).time(Activity::compute).total, 3000 * i);
    EXPECT_EQ(trace.worker_lane(i).spans().size(), 3000u);
  }
}

}  // namespace
}  // namespace weft::engine::trace_test

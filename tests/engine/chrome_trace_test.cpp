// Timelines as Chrome reads them: parsed back, events nest, arrows have both ends, names are escaped.
#include "engine/trace/chrome_trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/serialize.h"
#include "engine/json/json.h"

namespace weft::engine::chrome_trace_test {
namespace {

using Json = nlohmann::json;

std::string written(const std::vector<RankTimeline>& ranks, const Annotations& annotations = {}) {
  std::ostringstream out;
  write_chrome_trace(out, ranks, annotations);
  return out.str();
}

std::vector<Json> events(const std::vector<RankTimeline>& ranks, const std::string& phase,
                         const Annotations& annotations = {}) {
  const Json trace = Json::parse(written(ranks, annotations));
  std::vector<Json> found;
  for (const Json& event : trace["traceEvents"]) {
    if (event["ph"] == phase) found.push_back(event);
  }
  return found;
}

/// Rank `rank` with one worker, whose spans and departures are these.
RankTimeline rank_with(int rank, std::vector<Span> spans, std::vector<Departure> departures = {}) {
  return {Rank(rank),
          0,
          {"Part::refine", "Part::smooth"},
          {{"communication", {}, {}, 0}, {"worker 0", std::move(spans), std::move(departures), 0}}};
}

Span compute(TimePoint begin, TimePoint end, std::uint64_t cause = 0) {
  return {begin, end, ObjectId{Rank(3), 17}, 0, Activity::compute, cause};
}

std::int64_t nanoseconds(const Json& microseconds) {
  return static_cast<std::int64_t>(std::llround(microseconds.get<double>() * 1000));
}

TEST(ChromeTrace, OfNothingIsValidJson) {
  EXPECT_TRUE(Json::parse(written({}))["traceEvents"].empty());
  EXPECT_TRUE(events({rank_with(0, {})}, "X").empty());
}

TEST(ChromeTrace, NamesRanksAndThreads) {
  std::map<std::pair<int, int>, std::string> threads;
  std::map<int, std::string> processes;
  for (const Json& event : events({rank_with(0, {}), rank_with(1, {})}, "M")) {
    if (event["name"] == "process_name") processes[event["pid"]] = event["args"]["name"];
    if (event["name"] == "thread_name") threads[{event["pid"], event["tid"]}] = event["args"]["name"];
  }
  EXPECT_EQ(processes, (std::map<int, std::string>{{0, "rank 0"}, {1, "rank 1"}}));
  EXPECT_EQ((threads[{1, 0}]), "communication");
  EXPECT_EQ((threads[{1, 1}]), "worker 0");
}

TEST(ChromeTrace, SaysWhereNotAllRanksAreShown) {
  Annotations annotations;
  annotations.ranks = 160;
  const std::string some = written({rank_with(0, {}), rank_with(2, {})}, annotations);
  EXPECT_NE(some.find("\"rank 0 (2 of 160 ranks are shown)\""), std::string::npos) << some;
  EXPECT_NE(some.find("\"rank 2\""), std::string::npos);
  annotations.ranks = 2;
  EXPECT_EQ(written({rank_with(0, {}), rank_with(1, {})}, annotations).find("are shown"), std::string::npos);
}

TEST(ChromeTrace, WritesMicrosecondsSinceTheFirstEventWithoutLosingNanoseconds) {
  const TimePoint start = 1'700'000'000'123'456'789;
  const std::string text =
      written({rank_with(0, {compute(start + 7, start + 1'000'000'000'008)}, {{start, 1}})});
  EXPECT_NE(text.find("\"ts\":0.007"), std::string::npos) << text;
  EXPECT_NE(text.find("\"dur\":1000000000.001"), std::string::npos) << text;
}

TEST(ChromeTrace, PutsAllRanksOnTheClockOfRankZero) {
  RankTimeline late = rank_with(1, {compute(5'000, 6'000)});
  late.clock_offset = -3'000;
  const auto slices = events({rank_with(0, {compute(1'000, 2'000)}), late}, "X");
  ASSERT_EQ(slices.size(), 2u);
  EXPECT_EQ(nanoseconds(slices[0]["ts"]), 0);
  EXPECT_EQ(nanoseconds(slices[1]["ts"]), 1'000);
}

TEST(ChromeTrace, TellsMethodObjectAndMessageOfASpan) {
  const Json slice = events({rank_with(2, {compute(0, 1, 42)})}, "X").at(0);
  EXPECT_EQ(slice["name"], "Part::refine");
  EXPECT_EQ(slice["cat"], "compute");
  EXPECT_EQ(slice["pid"], 2);
  EXPECT_EQ(slice["tid"], 1);
  EXPECT_EQ(slice["args"], (Json{{"object", "3.17"}, {"message", 42}}));
}

TEST(ChromeTrace, TellsNothingOfWhatASpanDoesNotHave) {
  const Json slice = events({rank_with(0, {{0, 1, {}, Span::kNoName, Activity::communicate, 0}})}, "X").at(0);
  EXPECT_EQ(slice["name"], "communicate");
  EXPECT_TRUE(slice["args"].empty());
}

TEST(ChromeTrace, TellsUnpackingFromComputing) {
  const auto slices =
      events({rank_with(0, {{0, 1, {}, 1, Activity::unpack, 0}, {1, 2, {}, 99, Activity::unpack, 0}})}, "X");
  EXPECT_EQ(slices[0]["name"], "unpack Part::smooth");
  EXPECT_EQ(slices[1]["name"], "unpack") << "no such method";
}

TEST(ChromeTrace, EscapesNamesOfEveryKind) {
  const std::string name = "a\"b\\c\n\x01<T, 'ü'>";
  RankTimeline rank = rank_with(0, {compute(0, 1)});
  rank.method_names = {name};
  EXPECT_EQ(events({rank}, "X").at(0)["name"], name);
  rank.method_names = {"not utf-8: \xff"};
  EXPECT_EQ(events({rank}, "X").at(0)["name"], "not utf-8: \xEF\xBF\xBD");
}

TEST(ChromeTrace, SlicesOfALaneNestWithTheOuterFirst) {
  // As they are recorded: the inner ones end, and come, first.
  const std::vector<Span> spans = {compute(0, 10), compute(10, 20), compute(0, 30), compute(40, 50),
                                   compute(40, 50)};
  const auto slices = events({rank_with(0, spans)}, "X");
  std::vector<std::int64_t> open;  // ends
  std::int64_t last = 0;
  for (const Json& slice : slices) {
    const std::int64_t begin = nanoseconds(slice["ts"]), end = begin + nanoseconds(slice["dur"]);
    EXPECT_GE(begin, last) << "sorted";
    while (!open.empty() && open.back() <= begin) open.pop_back();
    EXPECT_TRUE(open.empty() || end <= open.back()) << "neither inside nor outside";
    open.push_back(end);
    last = begin;
  }
  EXPECT_EQ(nanoseconds(slices[0]["dur"]), 30);
}

TEST(ChromeTrace, ASpanThatEndsBeforeItBeginsHasNoDuration) {
  EXPECT_EQ(nanoseconds(events({rank_with(0, {compute(10, 5)})}, "X").at(0)["dur"]), 0);
}

TEST(ChromeTrace, DrawsAnArrowFromADepartureToEachSpanItCaused) {
  const std::vector<RankTimeline> ranks = {rank_with(0, {compute(0, 100)}, {{50, 7}}),
                                           rank_with(1, {compute(200, 210, 7), compute(220, 300, 7)})};
  const auto tails = events(ranks, "s"), heads = events(ranks, "f");
  ASSERT_EQ(tails.size(), 2u);
  ASSERT_EQ(heads.size(), 2u);
  std::set<Json> from, to;
  for (const Json& tail : tails) {
    EXPECT_EQ(tail["pid"], 0);
    EXPECT_EQ(nanoseconds(tail["ts"]), 50);
    from.insert(tail["id"]);
  }
  for (const Json& head : heads) {
    EXPECT_EQ(head["pid"], 1);
    EXPECT_EQ(head["bp"], "e");
    to.insert(head["id"]);
  }
  EXPECT_EQ(from.size(), 2u) << "each arrow its own number";
  EXPECT_EQ(from, to);
  EXPECT_EQ(nanoseconds(heads[0]["ts"]), 200);
}

/// Viewers bind an arrow to the slice around its start: it must be on the thread that sent the message.
TEST(ChromeTrace, StartsAnArrowOnTheLaneThatSentTheMessage) {
  RankTimeline rank = rank_with(0, {compute(0, 100), compute(200, 210, 7)});
  rank.lanes[0].departures = {{50, 7, 1}};  // kept by the communication thread's lane, which has the lock
  EXPECT_EQ(events({rank}, "s").at(0)["tid"], 1);
}

TEST(ChromeTrace, AnArrowNeverEndsBeforeItStarts) {
  const std::vector<RankTimeline> ranks = {rank_with(0, {compute(0, 100)}, {{50, 7}}),
                                           rank_with(1, {compute(40, 60, 7)})};  // its clock is off
  EXPECT_EQ(nanoseconds(events(ranks, "s").at(0)["ts"]), 40);
}

/// Two handlers on two ranks, with a node in each; the second rank's clock is behind by 1,000.
struct Annotated {
  std::vector<RankTimeline> ranks = {rank_with(0, {compute(0, 100)}), rank_with(1, {compute(-800, -700)})};
  Annotations annotations;

  Annotated() {
    ranks[1].clock_offset = 1000;
    annotations.object_kind = "subdomain";
    annotations.number_of = [](ObjectId object) {
      return object.number == 17 ? std::optional(4u) : std::nullopt;
    };
    annotations.names = {"propose", "gather", "propose -> gather"};
    annotations.steps = {{Rank(0), 1, 0, 100, 0, 4, 2}, {Rank(1), 1, 210, 290, 1, 5, 2}};
    annotations.links = {{0, 1, 60, 2}};
  }
};

TEST(ChromeTrace, CallsObjectsAsTheProgramDoes) {
  Annotated a;
  a.ranks[0].lanes[1].spans.push_back({150, 160, ObjectId{Rank(3), 18}, 0, Activity::compute, 0});
  const auto slices = events(a.ranks, "X", a.annotations);
  EXPECT_EQ(slices.at(0)["args"], (Json{{"subdomain", 4}}));
  EXPECT_EQ(slices.at(2)["args"], (Json{{"object", "3.18"}})) << "no subdomain";
}

TEST(ChromeTrace, ShowsStepsInsideTheirHandlers) {
  const Annotated a;
  const auto slices = events(a.ranks, "X", a.annotations);
  ASSERT_EQ(slices.size(), 4u);
  EXPECT_EQ(slices[0]["name"], "Part::refine") << "the handler, which is as long, is the outer one";
  EXPECT_EQ(slices[1]["name"], "propose");
  EXPECT_EQ(slices[1]["args"], (Json{{"subdomain", 4}, {"round", 2}, {"run", 0}}));
  EXPECT_EQ(slices[3]["name"], "gather");
  EXPECT_EQ(slices[3]["pid"], 1);
  EXPECT_EQ(slices[3]["tid"], 1);
  EXPECT_EQ(nanoseconds(slices[3]["ts"]), 210);
  EXPECT_EQ(nanoseconds(slices[3]["dur"]), 80);
}

TEST(ChromeTrace, DrawsLinksBetweenSteps) {
  Annotated a;
  const auto tails = events(a.ranks, "s", a.annotations), heads = events(a.ranks, "f", a.annotations);
  ASSERT_EQ(tails.size(), 1u);
  ASSERT_EQ(heads.size(), 1u);
  for (const char* same : {"id", "cat", "name"}) EXPECT_EQ(tails[0][same], heads[0][same]);
  EXPECT_EQ(tails[0]["name"], "propose -> gather");
  EXPECT_EQ(nanoseconds(tails[0]["ts"]), 60);
  EXPECT_EQ(nanoseconds(heads[0]["ts"]), 210);
  EXPECT_EQ(heads[0]["pid"], 1);
  a.annotations.steps[1].lane = Annotations::Step::kNoLane;
  EXPECT_TRUE(events(a.ranks, "s", a.annotations).empty()) << "one end is not shown";
  EXPECT_EQ(events(a.ranks, "X", a.annotations).size(), 3u);
}

TEST(ChromeTrace, NumbersLinksAndMessagesApart) {
  Annotated a;
  a.ranks[0].lanes[0].departures = {{50, 7, 1}};
  a.ranks[1].lanes[1].spans[0].cause = 7;
  std::set<Json> ids;
  for (const Json& tail : events(a.ranks, "s", a.annotations)) ids.insert(tail["id"]);
  EXPECT_EQ(ids.size(), 2u);
}

TEST(ChromeTrace, LeavesOutArrowsThatLackAnEnd) {
  const std::vector<RankTimeline> ranks = {rank_with(0, {compute(0, 100, 9)}, {{50, 7}})};
  EXPECT_TRUE(events(ranks, "s").empty());
  EXPECT_TRUE(events(ranks, "f").empty());
}

TEST(ChromeTrace, NoMessageCausesNothing) {
  const std::vector<RankTimeline> ranks = {rank_with(0, {compute(0, 100, 0)}, {{50, 0}})};
  EXPECT_TRUE(events(ranks, "s").empty());
  EXPECT_TRUE(events(ranks, "f").empty());
}

TEST(ChromeTrace, SaysHowMuchALaneLacks) {
  RankTimeline rank = rank_with(0, {});
  rank.lanes[1].dropped = 12;
  EXPECT_NE(written({rank}).find("worker 0 (12 events not kept)"), std::string::npos);
}

TEST(ChromeTrace, ManyEventsAreAllThere) {
  std::vector<Span> spans;
  std::vector<Departure> departures;
  for (int i = 0; i < 20'000; ++i) {
    spans.push_back(compute(10 * i, 10 * i + 5, static_cast<std::uint64_t>(i + 1)));
    departures.push_back({10 * i, static_cast<std::uint64_t>(i + 2)});  // causes the next
  }
  std::map<std::string, int> count;
  const Json trace = Json::parse(written({rank_with(0, spans, departures)}));
  for (const Json& event : trace["traceEvents"]) ++count[event["ph"]];
  EXPECT_EQ(count["X"], 20'000);
  EXPECT_EQ(count["s"], 19'999);
  EXPECT_EQ(count["f"], 19'999);
}

TEST(RankTimeline, TakesATraceThroughAPayload) {
  Trace trace(Rank(1), 2, 2, {.spans = true, .max_spans_per_lane = 1000});
  trace.communication_lane().departure({5, 77});
  for (int i = 0; i < 1001; ++i) trace.worker_lane(1).span(compute(i, i + 1, 5));
  RankTimeline timeline = timeline_of(trace, {"a", "b"}, -12);
  Packer packer(true);
  packer(timeline);
  RankTimeline copy;
  Unpacker unpacker(packer.take());
  unpacker(copy);
  unpacker.finish();
  EXPECT_EQ(copy.rank, Rank(1));
  EXPECT_EQ(copy.clock_offset, -12);
  EXPECT_EQ(copy.method_names, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(copy.lanes.size(), 3u);
  EXPECT_EQ(copy.lanes[0].name, "communication");
  EXPECT_EQ(copy.lanes[0].departures.at(0).id, 77u);
  EXPECT_EQ(copy.lanes[2].name, "worker 1");
  EXPECT_EQ(copy.lanes[2].spans.size(), 1000u);
  EXPECT_EQ(copy.lanes[2].spans.back().begin, 999);
  EXPECT_EQ(copy.lanes[2].dropped, 1u);
}

TEST(RankTimeline, HasLanesOfHelpersWhereThereWereAny) {
  Trace trace(Rank(0), 1, 1, {.spans = true}, 3);
  trace.helper_lane(2).span({4, 9, ObjectId{}, Span::kNoName, Activity::help, 0});
  const RankTimeline timeline = timeline_of(trace, {}, 0);
  ASSERT_EQ(timeline.lanes.size(), 3u);
  EXPECT_EQ(timeline.lanes[1].name, "worker 0");
  EXPECT_EQ(timeline.lanes[2].name, "helper 2");
  EXPECT_NE(written({timeline}).find(R"("name":"help","cat":"help")"), std::string::npos);
}

}  // namespace
}  // namespace weft::engine::chrome_trace_test

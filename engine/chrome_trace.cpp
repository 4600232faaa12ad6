// Chrome's trace event format, written event by event: a timeline may have millions.
#include "engine/chrome_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>
#include <utility>

namespace weft::engine {
namespace {

/// `text` as a JSON string; bytes that are not UTF-8 are replaced.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Joins messages to the spans that they caused. Each such span has an arrow of its own, since one arrow
/// cannot end twice; its number is the span's place in the order of messages.
class Arrows {
 public:
  explicit Arrows(std::span<const RankTimeline> ranks) {
    for (const RankTimeline& rank : ranks) {
      for (const LaneTimeline& lane : rank.lanes) {
        for (const Departure& departure : lane.departures) departed_.push_back(departure.id);
      }
    }
    std::sort(departed_.begin(), departed_.end());
    for (const RankTimeline& rank : ranks) {
      for (const LaneTimeline& lane : rank.lanes) add_heads(lane);
    }
    std::sort(heads_.begin(), heads_.end());
  }

  /// Calls `write` with the number of each arrow that starts with message `id`.
  template <class Write>
  void for_each_from(std::uint64_t id, const Write& write) const {
    for (std::size_t i = lower_bound({id, nullptr}); i < heads_.size() && heads_[i].message == id; ++i)
      write(i);
  }
  /// The same for the arrow that ends at `span`, if there is one.
  template <class Write>
  void for_each_to(const Span& span, const Write& write) const {
    const std::size_t i = lower_bound({span.cause, &span});
    if (i < heads_.size() && heads_[i].span == &span) write(i);
  }

 private:
  struct Head {
    std::uint64_t message;
    const Span* span;
    bool operator<(const Head& other) const {
      return message != other.message ? message < other.message : std::less<>()(span, other.span);
    }
  };

  void add_heads(const LaneTimeline& lane) {
    for (const Span& span : lane.spans) {
      if (span.cause == 0) continue;
      if (std::binary_search(departed_.begin(), departed_.end(), span.cause))
        heads_.push_back({span.cause, &span});
    }
  }
  std::size_t lower_bound(const Head& head) const {
    return static_cast<std::size_t>(std::lower_bound(heads_.begin(), heads_.end(), head) - heads_.begin());
  }

  std::vector<std::uint64_t> departed_;  // sorted
  std::vector<Head> heads_;              // sorted; both ends exist
};

/// A method as the spans of each activity show it.
class Labels {
 public:
  explicit Labels(const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < kActivities; ++i) {
      const std::string activity = name_of(static_cast<Activity>(i));
      const bool runs = static_cast<Activity>(i) == Activity::compute;
      for (const std::string& name : names) labels_[i].push_back(quoted(runs ? name : activity + ' ' + name));
      unnamed_[i] = quoted(activity);
    }
  }
  const std::string& operator()(const Span& span) const {
    const auto activity = static_cast<std::size_t>(span.activity);
    const auto& labels = labels_[activity];
    return span.name < labels.size() ? labels[span.name] : unnamed_[activity];
  }

 private:
  std::array<std::vector<std::string>, kActivities> labels_;
  std::array<std::string, kActivities> unnamed_;
};

/// Earliest time of all events, on rank 0's clock; 0 if there are none.
TimePoint start_of(std::span<const RankTimeline> ranks) {
  constexpr TimePoint kNone = std::numeric_limits<TimePoint>::max();
  TimePoint start = kNone;
  for (const RankTimeline& rank : ranks) {
    for (const LaneTimeline& lane : rank.lanes) {
      for (const Span& span : lane.spans) start = std::min(start, span.begin + rank.clock_offset);
      for (const Departure& departure : lane.departures) {
        start = std::min(start, departure.time + rank.clock_offset);
      }
    }
  }
  return start == kNone ? 0 : start;
}

/// Places of the spans such that one that holds others comes before them: viewers nest slices with equal
/// beginnings in the order of the file, and a lane keeps spans in the order in which they end.
std::vector<std::size_t> outermost_first(const std::vector<Span>& spans) {
  std::vector<std::size_t> order(spans.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    // The later recorded of two equal ones is the outer.
    return std::tuple(spans[a].begin, -spans[a].end, b) < std::tuple(spans[b].begin, -spans[b].end, a);
  });
  return order;
}

class Writer {
 public:
  Writer(std::ostream& out, std::span<const RankTimeline> ranks)
      : out_(out), start_(start_of(ranks)), arrows_(ranks) {}

  void write(std::span<const RankTimeline> ranks) {
    out_ << "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[";
    for (const RankTimeline& rank : ranks) write(rank);
    flush();
    out_ << "\n]}\n";
  }

 private:
  static constexpr std::size_t kFlushBytes = 1 << 16;

  /// One event; braces are part of `format`.
  template <class... Args>
  void event(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), "{}\n", first_ ? "" : ",");
    first_ = false;
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    if (text_.size() >= kFlushBytes) flush();
  }
  void flush() {
    out_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    text_.clear();
  }

  void write(const RankTimeline& rank) {
    pid_ = rank.rank.value;
    shift_ = rank.clock_offset - start_;
    name("process", 0, fmt::format("rank {}", pid_), pid_);
    const Labels labels(rank.method_names);
    for (std::size_t tid = 0; tid < rank.lanes.size(); ++tid) write(rank.lanes[tid], tid, labels);
  }
  void write(const LaneTimeline& lane, std::size_t tid, const Labels& labels) {
    const std::string lacks = lane.dropped == 0 ? "" : fmt::format(" ({} events not kept)", lane.dropped);
    name("thread", tid, lane.name + lacks, static_cast<std::int64_t>(tid));
    for (const std::size_t i : outermost_first(lane.spans)) write(lane.spans[i], tid, labels);
    for (const Departure& departure : lane.departures) write(departure, tid);
  }

  void name(const char* what, std::size_t tid, const std::string& text, std::int64_t place) {
    event(R"({{"ph":"M","name":"{}_name","pid":{},"tid":{},"args":{{"name":{}}}}})", what, pid_, tid,
          quoted(text));
    event(R"({{"ph":"M","name":"{}_sort_index","pid":{},"tid":{},"args":{{"sort_index":{}}}}})", what, pid_,
          tid, place);
  }
  void write(const Span& span, std::size_t tid, const Labels& labels) {
    const std::string object =
        span.object.valid() ? fmt::format(R"("object":"{}.{}")", span.object.home.value, span.object.number)
                            : "";
    const std::string message = span.cause != 0 ? fmt::format(R"("message":{})", span.cause) : "";
    const std::int64_t duration = std::max<std::int64_t>(span.end - span.begin, 0);
    event(R"({{"ph":"X","name":{},"cat":"{}","pid":{},"tid":{},"ts":{},"dur":{},"args":{{{}{}{}}}}})",
          labels(span), name_of(span.activity), pid_, tid, microseconds(span.begin + shift_),
          microseconds(duration), object, object.empty() || message.empty() ? "" : ",", message);
    arrows_.for_each_to(
        span, [&](std::size_t arrow) { end_of_arrow("f", R"("bp":"e",)", arrow, span.begin, tid); });
  }
  void write(const Departure& departure, std::size_t tid) {
    arrows_.for_each_from(departure.id,
                          [&](std::size_t arrow) { end_of_arrow("s", "", arrow, departure.time, tid); });
  }
  void end_of_arrow(const char* phase, const char* binding, std::size_t arrow, TimePoint time,
                    std::size_t tid) {
    event(R"({{"ph":"{}",{}"name":"message","cat":"message","id":{},"pid":{},"tid":{},"ts":{}}})", phase,
          binding, arrow, pid_, tid, microseconds(time + shift_));
  }

  /// Digits are cut, not computed: a double would lose the nanoseconds of a long run. `nanoseconds` >= 0.
  static std::string microseconds(std::int64_t nanoseconds) {
    return fmt::format("{}.{:03}", nanoseconds / 1000, nanoseconds % 1000);
  }

  std::ostream& out_;
  TimePoint start_;
  Arrows arrows_;
  fmt::memory_buffer text_;
  bool first_ = true;
  std::int32_t pid_ = 0;  // of the rank being written
  TimePoint shift_ = 0;   // from its clock to the file's
};

}  // namespace

RankTimeline timeline_of(const Trace& trace, std::vector<std::string> method_names,
                         std::int64_t clock_offset) {
  RankTimeline timeline{trace.rank(), clock_offset, std::move(method_names), {}};
  for (const Lane& lane : trace.lanes()) {
    const std::size_t place = timeline.lanes.size();
    timeline.lanes.push_back({place == 0 ? "communication" : fmt::format("worker {}", place - 1),
                              lane.spans().copy(), lane.departures().copy(),
                              lane.spans().dropped() + lane.departures().dropped()});
  }
  return timeline;
}

void write_chrome_trace(std::ostream& out, std::span<const RankTimeline> ranks) {
  Writer(out, ranks).write(ranks);
}

}  // namespace weft::engine

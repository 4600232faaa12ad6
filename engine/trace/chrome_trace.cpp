// Chrome's trace event format, written event by event: a timeline may have millions.
#include "engine/trace/chrome_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "engine/json/json.h"

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
      for (const LaneTimeline& lane : rank.lanes) add_heads(lane, rank.clock_offset);
    }
    std::sort(heads_.begin(), heads_.end());
  }

  std::size_t size() const { return heads_.size(); }
  /// Calls `write` with the number of each arrow that starts with message `id`, and the time on rank 0's
  /// clock when it ends.
  template <class Write>
  void for_each_from(std::uint64_t id, const Write& write) const {
    for (std::size_t i = lower_bound({id, nullptr, 0}); i < heads_.size() && heads_[i].message == id; ++i)
      write(i, heads_[i].time);
  }
  /// Calls `write` with the number of the arrow that ends at `span`, if there is one.
  template <class Write>
  void for_each_to(const Span& span, const Write& write) const {
    const std::size_t i = lower_bound({span.cause, &span, 0});
    if (i < heads_.size() && heads_[i].span == &span) write(i);
  }

 private:
  struct Head {
    std::uint64_t message;
    const Span* span;
    TimePoint time;
    bool operator<(const Head& other) const {
      return message != other.message ? message < other.message : std::less<>()(span, other.span);
    }
  };

  void add_heads(const LaneTimeline& lane, TimePoint offset) {
    for (const Span& span : lane.spans) {
      if (span.cause == 0) continue;
      if (std::binary_search(departed_.begin(), departed_.end(), span.cause))
        heads_.push_back({span.cause, &span, span.begin + offset});
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
      for (const std::string& name : names)
        labels_[i].push_back(quoted(runs ? name : fmt::format("{} {}", activity, name)));
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

/// A span, or a step, which lies in one.
struct Slice {
  TimePoint begin, end;  // on the rank's clock
  const Span* span;
  std::size_t step;  // without a span
};

/// Such that one that holds others comes before them: viewers nest slices with equal beginnings in the order
/// of the file, and a lane keeps spans in the order in which they end.
void sort_outermost_first(std::vector<Slice>& slices) {
  std::reverse(slices.begin(), slices.end());  // the later recorded of two equal ones is the outer
  std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) {
    return std::tuple(a.begin, -a.end, a.span == nullptr) < std::tuple(b.begin, -b.end, b.span == nullptr);
  });
}

class Writer {
 public:
  Writer(std::ostream& out, std::span<const RankTimeline> ranks, const Annotations& annotations)
      : out_(out), start_(start_of(ranks)), arrows_(ranks), annotations_(annotations) {
    for (const std::string& name : annotations.names) names_.push_back(quoted(name));
    kind_ = quoted(annotations.object_kind);
    for (std::size_t i = 0; i < annotations.steps.size(); ++i) {
      const Annotations::Step& step = annotations.steps[i];
      steps_of_[{step.rank.value, step.lane}].push_back(i);
    }
    for (std::size_t i = 0; i < annotations.links.size(); ++i) {
      const Annotations::Link& link = annotations.links[i];
      if (is_shown(link.from) && is_shown(link.to)) links_to_[link.to].push_back(i);
    }
  }

  void write(std::span<const RankTimeline> ranks) {
    out_ << "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[";
    const auto shown = static_cast<int>(ranks.size());
    for (const RankTimeline& rank : ranks)
      write(rank, &rank == ranks.data() && shown < annotations_.ranks
                      ? fmt::format(" ({} of {} ranks are shown)", shown, annotations_.ranks)
                      : "");
    for (const auto& [to, links] : links_to_)
      for (const std::size_t link : links) write_start_of_link(link);
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

  void write(const RankTimeline& rank, const std::string& remark) {
    pid_ = rank.rank.value;
    offset_ = rank.clock_offset;
    name("process", 0, fmt::format("rank {}{}", pid_, remark), pid_);
    const Labels labels(rank.method_names);
    for (std::size_t tid = 0; tid < rank.lanes.size(); ++tid) write(rank.lanes[tid], tid, labels);
    // Only now: each slice that an arrow starts in is there.
    for (const LaneTimeline& lane : rank.lanes)
      for (const Departure& departure : lane.departures) write(departure);
  }
  void write(const LaneTimeline& lane, std::size_t tid, const Labels& labels) {
    const std::string lacks = lane.dropped == 0 ? "" : fmt::format(" ({} events not kept)", lane.dropped);
    name("thread", tid, lane.name + lacks, static_cast<std::int64_t>(tid));
    for (const Slice& slice : slices_of(lane, tid)) {
      if (slice.span != nullptr)
        write(*slice.span, tid, labels);
      else
        write_step(slice.step);
    }
  }
  std::vector<Slice> slices_of(const LaneTimeline& lane, std::size_t tid) const {
    std::vector<Slice> slices;
    for (const Span& span : lane.spans) slices.push_back({span.begin, span.end, &span, 0});
    if (const auto mine = steps_of_.find({pid_, tid}); mine != steps_of_.end()) {
      for (const std::size_t i : mine->second) {
        const Annotations::Step& step = annotations_.steps[i];
        slices.push_back({step.begin - offset_, step.end - offset_, nullptr, i});
      }
    }
    sort_outermost_first(slices);
    return slices;
  }

  void name(const char* what, std::size_t tid, const std::string& text, std::int64_t place) {
    event(R"({{"ph":"M","name":"{}_name","pid":{},"tid":{},"args":{{"name":{}}}}})", what, pid_, tid,
          quoted(text));
    event(R"({{"ph":"M","name":"{}_sort_index","pid":{},"tid":{},"args":{{"sort_index":{}}}}})", what, pid_,
          tid, place);
  }
  std::string object_of(const Span& span) const {
    if (!span.object.valid()) return "";
    if (annotations_.number_of) {
      if (const auto number = annotations_.number_of(span.object))
        return fmt::format("{}:{}", kind_, *number);
    }
    return fmt::format(R"("object":"{}.{}")", span.object.home.value, span.object.number);
  }
  void write(const Span& span, std::size_t tid, const Labels& labels) {
    const std::string object = object_of(span);
    const std::string message = span.cause != 0 ? fmt::format(R"("message":{})", span.cause) : "";
    const std::int64_t duration = std::max<std::int64_t>(span.end - span.begin, 0);
    event(R"({{"ph":"X","name":{},"cat":"{}","pid":{},"tid":{},"ts":{},"dur":{},"args":{{{}{}{}}}}})",
          labels(span), name_of(span.activity), pid_, tid, on_file_clock(span.begin), microseconds(duration),
          object, object.empty() || message.empty() ? "" : ",", message);
    arrows_.for_each_to(span, [&](std::size_t arrow) {
      event(R"({{"ph":"f","bp":"e","name":"message","cat":"message","id":{},"pid":{},"tid":{},"ts":{}}})",
            arrow, pid_, tid, on_file_clock(span.begin));
    });
  }
  void write(const Departure& departure) {
    arrows_.for_each_from(departure.id, [&](std::size_t arrow, TimePoint end) {
      event(R"({{"ph":"s","name":"message","cat":"message","id":{},"pid":{},"tid":{},"ts":{}}})", arrow, pid_,
            departure.lane, microseconds(std::min(departure.time + offset_, end) - start_));
    });
  }

  bool is_shown(std::uint32_t step) const {
    return annotations_.steps.at(step).lane != Annotations::Step::kNoLane;
  }
  void write_step(std::size_t i) {
    const Annotations::Step& step = annotations_.steps[i];
    event(
        R"({{"ph":"X","name":{},"cat":"node","pid":{},"tid":{},"ts":{},"dur":{},"args":{{{}:{},"round":{},"run":{}}}}})",
        names_.at(step.name), pid_, step.lane, microseconds(step.begin - start_),
        microseconds(step.end - step.begin), kind_, step.object, step.round, i);
    const auto links = links_to_.find(static_cast<std::uint32_t>(i));
    if (links == links_to_.end()) return;
    for (const std::size_t link : links->second)
      event(R"({{"ph":"f","bp":"e","name":{},"cat":"edge","id":{},"pid":{},"tid":{},"ts":{}}})",
            names_.at(annotations_.links[link].name), arrows_.size() + link, pid_, step.lane,
            microseconds(step.begin - start_));
  }
  void write_start_of_link(std::size_t i) {
    const Annotations::Link& link = annotations_.links[i];
    const Annotations::Step& from = annotations_.steps.at(link.from);
    event(R"({{"ph":"s","name":{},"cat":"edge","id":{},"pid":{},"tid":{},"ts":{}}})", names_.at(link.name),
          arrows_.size() + i, from.rank.value, from.lane,
          microseconds(std::min(link.time, annotations_.steps[link.to].begin) - start_));
  }

  std::string on_file_clock(TimePoint time) const { return microseconds(time + offset_ - start_); }
  /// Digits are cut, not computed: a double would lose the nanoseconds of a long run. `nanoseconds` >= 0.
  static std::string microseconds(std::int64_t nanoseconds) {
    return fmt::format("{}.{:03}", nanoseconds / 1000, nanoseconds % 1000);
  }

  std::ostream& out_;
  TimePoint start_;
  Arrows arrows_;
  const Annotations& annotations_;
  std::vector<std::string> names_;  // of the annotations, as JSON
  std::string kind_;                // of objects, as JSON
  std::map<std::pair<std::int32_t, std::size_t>, std::vector<std::size_t>> steps_of_;  // by rank and lane
  std::map<std::uint32_t, std::vector<std::size_t>> links_to_;                         // by step
  fmt::memory_buffer text_;
  bool first_ = true;
  std::int32_t pid_ = 0;  // of the rank being written
  TimePoint offset_ = 0;  // from its clock to rank 0's
};

}  // namespace

RankTimeline timeline_of(const Trace& trace, std::vector<std::string> method_names,
                         std::int64_t clock_offset) {
  RankTimeline timeline{trace.rank(), clock_offset, std::move(method_names), {}};
  const auto add = [&](std::string name, const Lane& lane) {
    timeline.lanes.push_back({std::move(name), lane.spans().copy(), lane.departures().copy(),
                              lane.spans().dropped() + lane.departures().dropped()});
  };
  add("communication", trace.communication_lane());
  for (int i = 0; i < trace.workers(); ++i) add(fmt::format("worker {}", i), trace.worker_lane(i));
  for (int i = 0; i < trace.helpers(); ++i)  // most slots never have one
    if (trace.helper_lane(i).spans().size() > 0) add(fmt::format("helper {}", i), trace.helper_lane(i));
  return timeline;
}

void write_chrome_trace(std::ostream& out, std::span<const RankTimeline> ranks,
                        const Annotations& annotations) {
  Writer(out, ranks, annotations).write(ranks);
}

}  // namespace weft::engine

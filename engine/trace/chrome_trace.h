// Timelines of all ranks as one file for Perfetto (ui.perfetto.dev) or chrome://tracing.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "engine/base/rank.h"
#include "engine/trace/trace.h"

namespace weft::engine {

/// What one thread did, on its rank's clock.
struct LaneTimeline {
  std::string name;  ///< "communication", "worker 0"
  std::vector<Span> spans;
  std::vector<Departure> departures;
  std::uint64_t dropped = 0;  ///< spans and departures that were not kept
  template <class Archive>
  void serialize(Archive& archive) {
    archive(name, spans, departures, dropped);
  }
};

/// The part of a rank's trace that a timeline shows.
struct RankTimeline {
  Rank rank;
  std::int64_t clock_offset = 0;          ///< nanoseconds to add to this rank's times to get rank 0's
  std::vector<std::string> method_names;  ///< by index in the registry
  std::vector<LaneTimeline> lanes;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(rank, clock_offset, method_names, lanes);
  }
};

/// `clock_offset`: nanoseconds to add to times of this rank to get those of rank 0. The lanes' threads must
/// rest.
RankTimeline timeline_of(const Trace& trace, std::vector<std::string> method_names,
                         std::int64_t clock_offset);

/// What a program knows of its handlers and the engine does not. Times are on rank 0's clock.
struct Annotations {
  /// A part of a handler, within a span of its lane.
  struct Step {
    static constexpr std::uint32_t kNoLane = 0xFFFFFFFFu;
    Rank rank;
    std::uint32_t lane = kNoLane;  ///< in RankTimeline::lanes; kNoLane: not shown, nor are its links
    TimePoint begin = 0;
    TimePoint end = 0;
    std::uint32_t name = 0;  ///< in `names`
    std::uint64_t object = 0;
    std::uint64_t round = 0;
  };
  /// A value went from one step, at `time` during it, to another that could not begin before it was there.
  struct Link {
    std::uint32_t from = 0;  ///< in `steps`
    std::uint32_t to = 0;    ///< in `steps`
    TimePoint time = 0;
    std::uint32_t name = 0;  ///< in `names`
  };

  int ranks = 0;  ///< of the run; where fewer are shown, the name of the first says so
  /// What objects are called, as "subdomain", and the number by which users know one; none: it has only its
  /// id.
  std::string object_kind = "object";
  std::function<std::optional<std::uint64_t>(ObjectId)> number_of;
  std::vector<std::string> names;
  std::vector<Step> steps;
  std::vector<Link> links;
};

/// Writes the ranks as processes, their lanes as threads, spans as slices, and messages as arrows from where
/// they were sent to each span that they caused; arrows of which one end is missing are left out. Steps are
/// slices inside those of their handlers, with their place in Annotations::steps as "run", and links are
/// arrows between them. Where clocks that are off would let an arrow end before it starts, it starts when it
/// ends. Times are in microseconds since the first event. Memory besides the timelines: some
/// 50 bytes a span or step. Errors are those of `out`, which the caller checks.
void write_chrome_trace(std::ostream& out, std::span<const RankTimeline> ranks,
                        const Annotations& annotations = {});

}  // namespace weft::engine

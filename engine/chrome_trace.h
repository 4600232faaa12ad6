// Timelines of all ranks as one file for Perfetto (ui.perfetto.dev) or chrome://tracing.
#pragma once

#include <cstdint>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "engine/rank.h"
#include "engine/trace.h"

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

/// Writes the ranks as processes, their lanes as threads, spans as slices, and messages as arrows from the
/// departure to each span that they caused; arrows of which one end is missing are left out. Times are in
/// microseconds since the first event. Memory besides the timelines: some 30 bytes a span. Errors are those
/// of `out`, which the caller checks.
void write_chrome_trace(std::ostream& out, std::span<const RankTimeline> ranks);

}  // namespace weft::engine

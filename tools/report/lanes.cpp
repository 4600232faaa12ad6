#include "tools/report/lanes.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>

namespace weft::report {
namespace {

using engine::TimePoint;
using graph::dataflow::DumpedRun;
using graph::dataflow::GraphDump;
using graph::dataflow::RunIndex;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// The handlers of one object on one rank, ascending, with their lanes.
struct Handlers {
  struct Entry {
    TimePoint begin, end;
    std::uint32_t lane;
  };
  std::vector<Entry> entries;

  std::uint32_t lane_at(TimePoint time) const {
    auto after = std::upper_bound(entries.begin(), entries.end(), time,
                                  [](TimePoint t, const Entry& entry) { return t < entry.begin; });
    if (after == entries.begin()) return kNone;
    --after;
    return time <= after->end ? after->lane : kNone;
  }
};
using HandlersOf = std::map<std::pair<engine::Rank, engine::ObjectId>, Handlers>;

void add_lanes(const engine::RankTimeline& timeline, TimePoint start, Lanes& lanes, HandlersOf& handlers) {
  for (std::uint32_t thread = 0; thread < timeline.lanes.size(); ++thread) {
    const engine::LaneTimeline& lane = timeline.lanes[thread];
    const auto index = static_cast<std::uint32_t>(lanes.lanes.size());
    bool works = false;
    for (const engine::Span& span : lane.spans) {
      if (span.activity != engine::Activity::compute) continue;
      works = true;
      handlers[{timeline.rank, span.object}].entries.push_back(
          {span.begin + timeline.clock_offset - start, span.end + timeline.clock_offset - start, index});
    }
    if (works) lanes.lanes.push_back({timeline.rank, lane.name, thread});
  }
}

/// Lays runs that no span covers into rows, each into the first that is free.
class Rows {
 public:
  explicit Rows(Lanes& lanes) : lanes_(lanes) {}

  std::uint32_t row_for(const DumpedRun& run) {
    auto& rows = rows_[run.rank];
    for (auto& [lane, free_at] : rows) {
      if (free_at > run.begin) continue;
      free_at = run.end;
      return lane;
    }
    const auto lane = static_cast<std::uint32_t>(lanes_.lanes.size());
    lanes_.lanes.push_back({run.rank, "row " + std::to_string(rows.size())});
    rows.emplace_back(lane, run.end);
    return lane;
  }

 private:
  Lanes& lanes_;
  std::map<engine::Rank, std::vector<std::pair<std::uint32_t, TimePoint>>> rows_;
};

void sort_by_rank(Lanes& lanes) {
  std::vector<std::uint32_t> order(lanes.lanes.size()), old_to_new(lanes.lanes.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return lanes.lanes[a].rank < lanes.lanes[b].rank;
  });
  std::vector<Lane> sorted;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    old_to_new[order[i]] = i;
    sorted.push_back(lanes.lanes[order[i]]);
  }
  lanes.lanes = std::move(sorted);
  for (std::optional<std::uint32_t>& lane : lanes.of_run)
    if (lane) lane = old_to_new[*lane];
}

}  // namespace

Lanes lanes_of(const GraphDump& graph, std::span<const engine::RankTimeline> timelines, TimePoint start) {
  Lanes lanes;
  HandlersOf handlers;
  std::set<engine::Rank> shown;
  for (const engine::RankTimeline& timeline : timelines) {
    shown.insert(timeline.rank);
    add_lanes(timeline, start, lanes, handlers);
  }
  for (auto& [key, list] : handlers)
    std::sort(list.entries.begin(), list.entries.end(),
              [](const auto& a, const auto& b) { return a.begin < b.begin; });
  Rows rows(lanes);
  for (const DumpedRun& run : graph.runs) {
    if (!shown.empty() && !shown.contains(run.rank)) {
      lanes.of_run.push_back(std::nullopt);
      continue;
    }
    const auto found = handlers.find({run.rank, graph.instances[run.instance].object});
    std::uint32_t lane = found == handlers.end() ? kNone : found->second.lane_at(run.begin);
    if (lane == kNone) lane = rows.row_for(run);
    lanes.of_run.push_back(lane);
  }
  sort_by_rank(lanes);
  return lanes;
}

}  // namespace weft::report

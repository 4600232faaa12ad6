// Which worker ran each node: the rows of the report's timeline.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/trace/chrome_trace.h"
#include "graph/dataflow/dump/graph_dump.h"

namespace weft::report {

struct Lane {
  engine::Rank rank;
  std::string name;                          ///< "worker 0"
  std::optional<std::uint32_t> thread = {};  ///< in engine::RankTimeline::lanes; none for a "row"
};

struct Lanes {
  std::vector<Lane> lanes;                           ///< by rank, then worker
  std::vector<std::optional<std::uint32_t>> of_run;  ///< index in `lanes`, by RunIndex; none: not shown
};

/// `timelines`: of the ranks to show, with spans; none at all: all ranks. `start`: the time on rank 0's clock
/// that the graph's times count from. Where spans are missing, runs are laid into as few rows of their rank
/// as hold them, and those are called "row 0"...: who ran them is not known then.
Lanes lanes_of(const graph::dataflow::GraphDump& graph, std::span<const engine::RankTimeline> timelines,
               engine::TimePoint start);

}  // namespace weft::report

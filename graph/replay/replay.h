// A recorded graph on other ranks: the engine itself, with its directory, balancing and end, on simulated
// ranks whose handlers take the recorded times.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/balance/balancer.h"
#include "engine/simulate/simulation.h"
#include "engine/trace/chrome_trace.h"
#include "engine/trace/summary.h"
#include "graph/dataflow/dump/graph_dump.h"

namespace weft::graph::replay {

struct ReplayOptions {
  int ranks = 1;
  int threads = 1;  ///< workers a rank; a task takes one, as it took when it was recorded
  engine::NetworkModel network = {};
  engine::BalancerFactory balancer = engine::work_stealing();
  double slowdown = 1;                   ///< of every task: cores that are all busy are slower
  std::uint64_t object_bytes = 1 << 20;  ///< of an instance that moves
  bool timelines = false;
};

struct Replayed {
  engine::RunSummary engine;
  std::vector<engine::RankTimeline> timelines;  ///< where asked for, by rank; not of each of many
  dataflow::GraphDump graph;                    ///< the recorded one with the times and ranks of the replay
  engine::SimulationResult simulation;
  double seconds = 0;                       ///< from the first task's begin to the last one's end
  double work = 0;                          ///< seconds of all tasks
  std::vector<std::uint64_t> most_objects;  ///< by rank: the most instances that it had at a time
};

/// Throws std::invalid_argument for a graph that was not executed.
Replayed replay(const dataflow::GraphDump& recorded, const ReplayOptions& options);

}  // namespace weft::graph::replay

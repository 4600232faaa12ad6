// A run of the subdomains' graph without meshes or ranks: a discrete simulation of the protocol on workers,
// with random durations, from which logs, timelines and summaries are made as the engine makes them.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/trace/chrome_trace.h"
#include "engine/trace/summary.h"
#include "graph/dataflow/execution_log.h"
#include "graph/dataflow/graph_description.h"

namespace weft::testing {

struct SimulationRules {
  std::uint32_t subdomains = 8;
  std::uint32_t ranks = 2;
  std::uint32_t workers = 2;  ///< of each rank
  std::uint32_t rounds = 3;
  bool migration = false;         ///< subdomains change ranks between handlers
  std::int64_t largest_skew = 0;  ///< nanoseconds by which ranks' clocks are off, in both directions
  std::uint64_t seed = 1;
};

struct SimulatedRun {
  graph::dataflow::GraphDescription graph;
  graph::dataflow::ExecutionLog log;  ///< of all ranks
  std::vector<engine::RankTimeline> timelines;
  engine::RunSummary summary;
  std::vector<std::vector<std::uint32_t>> neighbours;  ///< of each subdomain
  std::int64_t wall = 0;                               ///< nanoseconds on a perfect clock
};

/// The same rules give the same run.
SimulatedRun simulate(const SimulationRules& rules);

engine::ObjectId object_of_subdomain(const SimulationRules& rules, std::uint32_t subdomain);
std::uint64_t subdomain_of_object(const SimulationRules& rules, engine::ObjectId object);

}  // namespace weft::testing

// A task graph, planned or executed, as one document: what JSON, DOT and GraphML are written from.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/rank.h"
#include "engine/trace/trace.h"
#include "graph/dataflow/execution_log.h"
#include "graph/dataflow/graph_description.h"

namespace weft::graph::dataflow {

/// Index in GraphDump::instances.
using InstanceIndex = std::uint32_t;
/// Index in GraphDump::runs.
using RunIndex = std::uint32_t;

/// An instance and the number by which users know it (a subdomain's).
struct DumpedInstance {
  std::uint64_t number = 0;
  engine::ObjectId object;
  engine::Rank rank;  ///< planned: where it starts; executed: where most of its time was spent
};

/// Two instances between which values travel. Planned: a permission, all counts 0.
struct NetworkLink {
  InstanceIndex from = 0;
  InstanceIndex to = 0;
  EdgeIndex edge = 0;  ///< a remote edge
  std::uint64_t values = 0;
  std::uint64_t bytes = 0;
};

/// A node has run once.
struct DumpedRun {
  NodeIndex node = 0;
  InstanceIndex instance = 0;
  std::uint64_t round = 0;
  engine::Rank rank;
  engine::TimePoint begin = 0;  ///< nanoseconds since the first run began
  engine::TimePoint end = 0;
  std::uint64_t bytes_received = 0;
  std::vector<double> counters;  ///< by index in GraphDump::counter_names; shorter where the last ones are 0
};

/// A value has gone from run to run.
struct DumpedUse {
  EdgeIndex edge = 0;
  RunIndex from = 0;
  RunIndex to = 0;
  engine::TimePoint time = 0;  ///< when it was sent; nanoseconds since the first run began
  std::uint64_t bytes = 0;     ///< 0 on local edges
};

/// The chain of runs that took longest; see critical_path.h.
struct CriticalPath {
  engine::TimePoint length = 0;  ///< nanoseconds of work in the chain
  engine::TimePoint wall = 0;    ///< nanoseconds from the first begin to the last end
  struct Step {
    RunIndex run = 0;
    engine::TimePoint worked = 0;             ///< of the run, what the chain had to wait for
    std::optional<std::uint32_t> arrived_by;  ///< index in GraphDump::uses; none: it followed in its instance
  };
  std::vector<Step> steps;  ///< in the order of time
};

struct GraphDump {
  GraphDescription description;
  std::vector<DumpedInstance> instances;
  std::vector<NetworkLink> network;  ///< by from, to, edge
  std::vector<std::string> counter_names;
  std::vector<DumpedRun> runs;       ///< by begin; within an instance in the order in which they happened
  std::vector<DumpedUse> uses;       ///< by `to`, then time
  std::uint64_t unmatched_uses = 0;  ///< uses of which one of the runs is missing
  CriticalPath critical_path;        ///< of the whole run, also in what a filter leaves

  bool executed() const { return !runs.empty(); }
};

/// The number by which users know an instance.
using NumberOf = std::function<std::uint64_t(engine::ObjectId)>;

/// The planned graph: every instance and who may send to whom. `neighbours`: pairs of indices of `instances`,
/// each in both directions where both may send. Throws std::out_of_range for an index that is none.
GraphDump planned_dump(GraphDescription description, std::vector<DumpedInstance> instances,
                       const std::vector<std::pair<InstanceIndex, InstanceIndex>>& neighbours);

/// The executed graph. `log`: of all ranks, on one clock (gather_log()). A use joins the run within which it
/// was sent and its target's run in its round; of several such runs in one instance, the first that comes
/// after it and that no other use has. Clocks of ranks need agree only for the times that are shown.
GraphDump executed_dump(GraphDescription description, const ExecutionLog& log, const NumberOf& number_of);

/// When the first run of a log began: what the dump's times count from. 0 without runs.
engine::TimePoint start_of(const ExecutionLog& log);

/// What is left of a graph.
struct DumpFilter {
  std::optional<std::uint64_t> round = {};
  std::optional<std::uint64_t> instance = {};  ///< its number
  bool critical_path_only = false;
};
/// The runs that fulfil all of the filter and the uses between them. The network keeps the links of which an
/// end is left; by round or path, those of which a use is left. Throws std::invalid_argument when the
/// instance is none of the graph's, or rounds or paths are asked of a planned graph.
GraphDump filtered(const GraphDump& dump, const DumpFilter& filter);

/// Whether each run is a step of the critical path, by RunIndex.
std::vector<bool> on_critical_path(const GraphDump& dump);

/// Adds up the uses by pairs of instances and remote edge.
std::vector<NetworkLink> network_of(const GraphDump& dump);

}  // namespace weft::graph::dataflow

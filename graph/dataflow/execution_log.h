// What the nodes of instances have done and when: the executed graph.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/rank.h"
#include "engine/trace/trace.h"
#include "graph/dataflow/graph_description.h"

namespace weft::graph::dataflow {

class RankExchange;

/// Whether an instance keeps an ExecutionLog.
enum class Recording : std::uint8_t { off, on };

/// A node has run once. Plain data.
struct NodeRun {
  NodeIndex node = 0;
  engine::ObjectId instance;
  std::uint64_t round = 0;
  engine::Rank rank;                 ///< where it ran
  engine::TimePoint begin = 0;       ///< nanoseconds on that rank's clock; rank 0's after gather_log()
  engine::TimePoint end = 0;         ///< the same; the local successors' runs are not within it
  std::uint64_t bytes_received = 0;  ///< of an event: packed size of its arrivals' values
  std::uint32_t first_counter = 0;   ///< the run's counters: a range of ExecutionLog::counters
  std::uint32_t counters = 0;
};

/// Counter of every run: processor time of the thread that ran it. What other threads helped with is not in
/// it.
inline constexpr const char* kProcessorSeconds = "processor, seconds";

/// A value has been passed along an edge. Plain data.
struct EdgeUse {
  EdgeIndex edge = 0;
  engine::ObjectId from;
  engine::ObjectId to;         ///< the same as `from` on local edges
  std::uint64_t round = 0;     ///< in which the target node is to run
  std::uint64_t bytes = 0;     ///< packed size of the value; 0 on local edges, where nothing is packed
  engine::Rank rank;           ///< where it was sent
  engine::TimePoint time = 0;  ///< when it was sent, on the same clock as NodeRun's
};

/// What a body has counted: NodeContext::count().
struct Counter {
  std::uint32_t name = 0;  ///< index in ExecutionLog::counter_names
  double value = 0;
};

/// Of one instance, of one rank or of all. Within an instance, runs and uses are in the order in which they
/// happened.
struct ExecutionLog {
  std::vector<NodeRun> runs;
  std::vector<EdgeUse> uses;
  std::vector<Counter> counters;
  std::vector<std::string> counter_names;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(runs, uses, counters, counter_names);
  }

  /// Adds to a counter of the last of `runs`.
  void count(std::string_view name, double amount);

  /// The value of a run's counter; 0 when it was not counted.
  double counter(const NodeRun& run, std::string_view name) const;

  /// Adds all of another log behind this one's.
  void append(ExecutionLog&& other);
};

/// All runs of one node.
struct NodeSum {
  std::string node;
  std::uint64_t count = 0;
  double seconds = 0;
  double longest = 0;  ///< seconds
};

/// By NodeIndex.
std::vector<NodeSum> sums_of(const GraphDescription& graph, const ExecutionLog& log);

/// The logs of all ranks at rank 0, in the order of the ranks, their times on rank 0's clock; elsewhere
/// empty. All ranks must call it. Sent point-to-point.
ExecutionLog gather_log(RankExchange& exchange, ExecutionLog mine);

}  // namespace weft::graph::dataflow

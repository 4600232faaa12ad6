// Why a run of a graph took as long as it did: the longest chain of work, and who was waited for.
#pragma once

#include <string>
#include <vector>

#include "graph/dataflow/dump/graph_dump.h"

namespace weft::graph::dataflow {

/// The longest chain of runs of which each had to wait for the one before: because it follows in the same
/// instance, or because it got a value from it. Of a run that sent a value before its end, the chain contains
/// what came before the sending. No machine can be faster than this chain with these times; it is never
/// longer than the wall time, not even where the clocks of ranks disagree. Throws std::invalid_argument when
/// runs wait for each other in a circle.
CriticalPath critical_path(const GraphDump& dump);

/// What the critical path is made of.
struct PathShare {
  NodeIndex node = 0;
  std::uint64_t runs = 0;
  engine::TimePoint worked = 0;  ///< nanoseconds; all add up to CriticalPath::length
};
/// By NodeIndex, those that occur.
std::vector<PathShare> shares_of(const GraphDump& dump);

/// An instance had nothing to do until a value came.
struct Wait {
  RunIndex run = 0;              ///< of the event that the instance waited for
  RunIndex for_run = 0;          ///< that sent the last value
  engine::TimePoint waited = 0;  ///< nanoseconds from the end of the instance's run before to the sending
};
/// All waits longer than nothing, by run. The workers of the rank may have worked for other instances
/// meanwhile.
std::vector<Wait> waits_of(const GraphDump& dump);

}  // namespace weft::graph::dataflow

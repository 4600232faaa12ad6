// A recorded graph as what has to be done again: the handlers of each instance, what each waits for, how long
// it works and what it sends when.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/rank.h"
#include "engine/trace/trace.h"
#include "graph/dataflow/dump/graph_dump.h"

namespace weft::graph::replay {

/// Virtual seconds that can be simulated: of one task's end in the recording, and of all tasks of a replay
/// together. Ranks that wait send each other a sign of life every second.
inline constexpr double kMostSeconds = 1e7;

/// Index in ReplayPlan::handlers.
using HandlerIndex = std::uint32_t;

/// A value that a handler sends.
struct PlannedSend {
  engine::TimePoint after = 0;  ///< nanoseconds of the run's work
  std::uint32_t to = 0;         ///< instance
  HandlerIndex handler = 0;     ///< of that instance, which waits for it
  std::uint64_t bytes = 0;
};

/// One run of a node.
struct PlannedRun {
  dataflow::RunIndex run = 0;  ///< in the recorded graph
  engine::TimePoint works = 0;
  std::vector<PlannedSend> sends;  ///< in the order of their times
};

/// A handler of an instance: the run of an event, a start or a wake node, and what follows from it locally.
struct PlannedHandler {
  std::vector<PlannedRun> runs;
  std::uint32_t values = 0;                ///< it waits for so many
  std::optional<HandlerIndex> wakes = {};  ///< of the same instance: runs at the first of these values
  double expected = 0;  ///< seconds: what handlers of this node take in this round on average
};

struct ReplayPlan {
  std::vector<PlannedHandler> handlers;              ///< those of an instance in the order in which they ran
  std::vector<std::vector<HandlerIndex>> instances;  ///< by InstanceIndex
  engine::TimePoint work = 0;                        ///< of all runs
};

/// `slowdown`: every run takes so many times as long. Throws std::invalid_argument for a graph that was not
/// executed, and for one whose runs take more than kMostSeconds.
ReplayPlan plan_of(const dataflow::GraphDump& dump, double slowdown = 1);

/// Of counters like "quality check, seconds", which count a part of their run's time: a run that is given
/// another duration has counted so many times as much.
class SecondsCounters {
 public:
  explicit SecondsCounters(const std::vector<std::string>& names);
  void leave_out(std::size_t place) { std::erase(places_, place); }
  void scale(dataflow::DumpedRun& run, double factor) const;
  bool has(std::size_t place) const {
    return std::find(places_.begin(), places_.end(), place) != places_.end();
  }

 private:
  std::vector<std::size_t> places_;  ///< in GraphDump::counter_names
};

/// How many times as long; 1 of what took no time.
double ratio_of(engine::TimePoint is, engine::TimePoint was);

/// Makes the runs as long as the processor time that was counted in each (dataflow::kProcessorSeconds), for
/// recordings on a machine that others used; sound where a rank had one thread. Throws std::invalid_argument
/// for a graph without, or where they are no times.
void take_processor_times(dataflow::GraphDump& dump);

/// Of an enlarged graph, which takes up to a kilobyte for each.
inline constexpr double kMostRuns = 1e7;

struct Enlargement {
  std::uint32_t copies = 1;  ///< so many times the mesh, in subdomains of the same size
  std::uint32_t split = 1;   ///< so many times the subdomains of the same mesh, each so much smaller
  double grow = 1;           ///< so many times the tets in each subdomain
  std::uint64_t seed = 1;
};

/// A graph of `copies * split` times as many instances, which are as those of the recording. Split, each copy
/// has all parts of each recorded instance, whose runs take what DurationModel::of_part() says. Else the
/// first copy is the recording itself where sizes stay; the others have sizes drawn from the recorded ones,
/// times `grow`, and their runs take what DurationModel::draw() says. Values have the bytes of a surface.
/// Each instance of a copy sends every `kCrossing`-th value to its twin in the next copy and waits for as
/// many from that of the one before, so copies wait for each other as parts of one mesh do. Where sizes
/// change, only sizes and seconds are left of what was counted: nothing is known of the rest. Throws
/// std::invalid_argument for sizes that are none, and for more than kMostRuns runs.
dataflow::GraphDump enlarged(const dataflow::GraphDump& dump, const Enlargement& enlargement);

}  // namespace weft::graph::replay

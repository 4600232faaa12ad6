// The times of a log, which come from the clocks of all ranks, on one clock.
#pragma once

#include <vector>

#include "graph/dataflow/execution_log.h"

namespace weft::graph::dataflow {

/// Adds to the times of each run and use the offset of the rank where it happened; `offset_of_rank`:
/// nanoseconds, by rank. An instance that has moved brings along times of every rank that it was on, so a log
/// cannot be shifted as a whole. Throws std::out_of_range for a rank that has none.
void to_common_clock(const std::vector<engine::TimePoint>& offset_of_rank, ExecutionLog& log);

}  // namespace weft::graph::dataflow

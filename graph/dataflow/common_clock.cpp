#include "graph/dataflow/common_clock.h"

namespace weft::graph::dataflow {

void to_common_clock(const std::vector<engine::TimePoint>& offset_of_rank, ExecutionLog& log) {
  for (NodeRun& run : log.runs) {
    const engine::TimePoint offset = offset_of_rank.at(run.rank.index());
    run.begin += offset, run.end += offset;
  }
  for (EdgeUse& use : log.uses) use.time += offset_of_rank.at(use.rank.index());
}

}  // namespace weft::graph::dataflow

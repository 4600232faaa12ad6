// What is known after a run in subdomains beyond what any run leaves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/trace/summary.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "weft/weft.h"

namespace weft::tools {

/// From the runs of all nodes, the engine's summaries and the shifts of all subdomains.
DistributedStats account_for(const graph::dataflow::ExecutionLog& log,
                             std::vector<engine::RankSummary> summaries,
                             const std::vector<graph::adaptation::ShiftRecord>& shifts);

/// A line each on what the run went on from and what it has written; empty where neither.
std::string checkpoints_text(const CheckpointStats& account);
/// The readable account: times by operation, shifts, messages.
std::string subdomains_text(const DistributedStats& account);

}  // namespace weft::tools

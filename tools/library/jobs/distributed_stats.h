// What is known after a run in subdomains beyond what any run leaves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/trace/summary.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "partition/communication/peers.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: this rank's seconds by operation, of nodes from the logs of the instances that are on any rank
/// (`log`: of those here), of the rest from the engine.
RankStats seconds_of_rank(partition::Peers& peers, const graph::dataflow::ExecutionLog& log,
                          const engine::RankSummary& summary);

/// Sums over all ranks, which call it together: operations and shifts go up and down the tree as sums.
/// `by_rank`: each rank's operations are kept too.
DistributedStats account_for(partition::Peers& peers, const RankStats& mine,
                             const std::vector<graph::adaptation::ShiftRecord>& shifts, bool by_rank);
/// Of the engine, where it is known: on rank 0.
void add_engine(engine::RunSummary summary, DistributedStats& account);

/// Over all ranks.
ExchangeStats sum_exchanges(partition::Peers& peers, const engine::Exchanged& mine);

/// A line each on what the run went on from and what it has written; empty where neither.
std::string checkpoints_text(const CheckpointStats& account);
/// The readable account: times by operation, shifts, messages.
std::string subdomains_text(const DistributedStats& account);

}  // namespace weft::tools

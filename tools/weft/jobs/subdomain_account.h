// What is known after a run in subdomains beyond what any run leaves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/trace/summary.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "meshing/metric/measures.h"

namespace weft::tools {

/// Seconds of all workers in one operation, in the order and with the names of the paper's figure of the
/// percentage breakdown, and those that the paper does not have.
struct OperationTime {
  std::string name;
  double seconds = 0;
};

struct RankAccount {
  int rank = 0;
  std::vector<OperationTime> operations;
};

/// One round of shifts over all subdomains.
struct ShiftAccount {
  std::uint64_t round = 0;
  std::uint64_t wanted = 0;     ///< interface vertices to be freed, once for each subdomain that has them
  std::uint64_t moved = 0;      ///< tets
  std::uint64_t receivers = 0;  ///< subdomains that received any
  std::uint64_t thawed = 0;     ///< copies of vertices that are no interface any more
};

struct DistributedStats {
  std::uint32_t subdomains = 0;
  int ranks = 1;
  std::string partitioner;
  int layers = 0;
  std::uint32_t checks = 0;  ///< of all invariants; 0: not asked for
  double decomposition_seconds = 0, adaptation_seconds = 0;
  std::uint32_t coarse_shifts = 0;  ///< of `shifts`, those of phases to coarser metrics
  std::vector<ShiftAccount> shifts;
  std::vector<RankAccount> by_rank;
  std::vector<OperationTime> sum;      ///< of all ranks
  double beside_adaptation = 0;        ///< share of the busy time that is not spent adapting
  meshing::Measures former_interface;  ///< tets with a vertex that has been one of an interface
  engine::RunSummary engine;
};

/// From the runs of all nodes, the engine's summaries and the shifts of all subdomains.
DistributedStats account_for(const graph::dataflow::ExecutionLog& log,
                             std::vector<engine::RankSummary> summaries,
                             const std::vector<graph::adaptation::ShiftRecord>& shifts);

/// The readable account: times by operation, shifts, messages.
std::string subdomains_text(const DistributedStats& account);

}  // namespace weft::tools

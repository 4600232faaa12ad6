// Which metrics a run adapts to before the wanted one, and when subdomains divide.
#pragma once

#include <cstdint>

#include "graph/adaptation/subdomain_task.h"
#include "partition/distribute/distribute.h"

namespace weft::graph::adaptation {

/// What a plan is made from, but for what is known of the input.
struct PlanOptions {
  std::uint32_t subdomains = 1;
  std::uint32_t most_shifts = kMostShifts;
  partition::Partitioner partitioner;
  double tets_of_seed = 1e5;  ///< DistributedOptions
};

/// How many subdomains have tets at first: all, or fewer where the input is far from its metric, has few
/// tets, or one that alone would become too much for a subdomain. Those few make a mesh with some hundred
/// tets for each of all subdomains, and are divided.
std::uint32_t parts_at_first(const partition::InputMeasures& input, const PlanOptions& options);

/// Fills AdaptationPlan::phases and all about division, from subdomains, most_shifts and what is known now.
void plan_phases(const partition::Distributed& distributed, std::uint64_t input_tets, AdaptationPlan& plan);

}  // namespace weft::graph::adaptation

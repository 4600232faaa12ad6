// A run that goes on from a checkpoint, on whatever ranks.
#pragma once

#include <cstdint>
#include <span>

#include "engine/run/runtime.h"
#include "graph/adaptation/checkpoint_files.h"
#include "graph/adaptation/subdomain_task.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::graph::adaptation {

/// The same for runs that may go on from each other's checkpoints, on any ranks: a hash of the input as it
/// was decomposed, its metric, and the plan. `program`: of anything else that matters.
std::uint64_t hash_of_run(partition::Peers& peers, std::span<const partition::SubdomainStart> starts,
                          const AdaptationPlan& plan, std::uint64_t program);

/// All ranks, between runs: makes the subdomains of the checkpoint, in equal numbers on all ranks, with what
/// waits for them; the next run goes on. plan.home_ranks must be the checkpoint's. Throws
/// meshing::InputError on all ranks alike.
void restore_subdomains(engine::Runtime& runtime, partition::Peers& peers, const AdaptationPlan& plan,
                        const CheckpointPlace& place);

}  // namespace weft::graph::adaptation

// Work that all ranks of mpirun do together, and who tells what went wrong.
#pragma once

#include <functional>

#include "partition/communication/peers.h"
#include "tools/library/jobs/ranks.h"

namespace weft::tools {

/// Does work of all ranks. What all throw alike (InputError, std::invalid_argument but OptionError,
/// partition::InvariantViolation) the rank that is the `first` by then throws as InputError, the others as a
/// RunError that counts as reported.
void telling(const bool& first, const std::function<void()>& work);

/// Runs the body on the ranks of mpirun, or in this process, telling() for rank 0.
void on_world_telling(const RankBody& body);

/// The same for work that needs no more than the exchange of data; loops use at most `threads` threads of a
/// rank, for other ranks have the other cores. Returns whether this is rank 0.
bool on_peers_of_world(const std::function<void(partition::Peers&)>& body, int threads = 1);

}  // namespace weft::tools

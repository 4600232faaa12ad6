// The ranks that a run works on: those of mpirun, those of a caller's communicator, or this process alone.
#pragma once

#include <mpi.h>

#include <functional>

#include "engine/network/transport.h"
#include "engine/simulate/simulation.h"

namespace weft::tools {

/// What all ranks do; all throw InputError and std::invalid_argument alike.
using RankBody = std::function<void(engine::Transport&)>;

/// Runs the body on the ranks of mpirun where it started this process, else here alone. Throws what the body
/// throws alike on all ranks; RunError for anything else.
void on_world(const RankBody& body);

/// The same on a communicator of the caller's, who has initialised MPI and will finalise it.
void on_communicator(MPI_Comm communicator, const RankBody& body);

/// The same in this process alone, without MPI.
void on_one_rank(const RankBody& body);

/// The same on ranks that are simulated, one after the other in this thread: the body is called for all of
/// them here.
engine::SimulationResult on_simulated_ranks(const engine::SimulationOptions& options, const RankBody& body);

}  // namespace weft::tools

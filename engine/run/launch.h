// The frame of a program that uses the engine.
#pragma once

#include <functional>

#include "engine/mpi/mpi_transport.h"
#include "engine/network/transport.h"

namespace weft::engine {

/// Exit status of a run that failed.
inline constexpr int kExitFailed = 2;

/// Connects the ranks (those of mpirun if it started this program, else this process alone), calls `body`,
/// and disconnects. Returns what `body` returns; kExitFailed when the run failed on any rank, and then one
/// rank has written why to stderr. A rank that leaves `body` with another exception takes the others down;
/// where one returns something else than 0 alone, the runs that others are in fail.
/// If MPI is running already, its world is used as run_on() does, and MPI is not finalised.
int launch(int argc, char** argv, const std::function<int(Transport&)>& body,
           MpiTransportOptions options = {});

/// For libraries: connects the ranks of a communicator of the caller (see MpiTransport), calls `body` on
/// each, and disconnects. Of all its ranks together. It never ends the process and writes nothing itself.
///
/// What `body` throws is thrown again when the network has been closed. A rank whose `body` throws tells the
/// others, so nobody waits for it in a run: the runs that others are in or begin fail, and when all have come
/// here they close together. Ranks whose `body` has not thrown then throw a RunFailure that says which rank
/// left, and why; so either no rank throws, or all do.
/// When a rank has died, or the network fails, nobody waits: the network is abandoned (see MpiTransport) and
/// RunFailure::network_broken() is true.
/// What cannot be helped: a rank that stays in code of its own, outside of run() and this function, is
/// waited for.
void run_on(CallersCommunicator communicator, const std::function<void(Transport&)>& body,
            MpiTransportOptions options = {});

/// The same on any transport, which is closed or abandoned afterwards.
void run_and_close(Transport& transport, const std::function<void(Transport&)>& body);

}  // namespace weft::engine

// Thousands of ranks in one thread: each is a fiber that runs the program as a process would, their
// transports pass packets by a model of the network, and their clocks are virtual.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/network/transport.h"
#include "engine/simulate/network_model.h"

namespace weft::engine {

struct SimulationOptions {
  int ranks = 1;
  NetworkModel network = {};

  /// Time is that of the processor, without what the simulation takes, times `slowdown`; each end of a packet
  /// takes the network's overhead. No two simulations take the same. False: time passes only where
  /// VirtualTime::spend() says so, and by the figures below; every simulation takes the same.
  bool measured = true;
  double slowdown = 1;

  /// That the workers of all ranks share, as on one machine; 0: each worker has its own. Communication
  /// threads, which have little to do, take none of their time, but one that wakes while workers run on all
  /// waits for so many seconds, as those of real runs do (tests/experiments/2026-11-27-simulation.md).
  int cores = 0;
  double core_wait = 4e-4;

  // Where time is not measured.
  double handler_overhead = 1e-6;  ///< seconds of the engine for each handler
  double copy_rate = 4e9;          ///< bytes a second that are packed or unpacked

  std::size_t stack_bytes = std::size_t{1} << 20;  ///< of each rank; memory only as far as it is used
};

struct SimulationResult {
  double seconds = 0;         ///< virtual, until the last rank has ended
  std::uint64_t packets = 0;  ///< between ranks
  std::uint64_t bytes = 0;    ///< of these
  std::uint64_t turns = 0;    ///< of all ranks
  double real_seconds = 0;    ///< that the simulation took
};

/// Calls `body` on each rank, and closes its transport, as run_and_close() does; throws what the lowest rank
/// has thrown. The ranks take turns on the calling thread, the earliest clock first, of equal ones in a fixed
/// order; parallel loops use this thread only. A Runtime on such a transport has no workers: its handlers run
/// within the turns, with threads as many at a time as RuntimeOptions says, on virtual time.
SimulationResult simulate(const SimulationOptions& options, const std::function<void(Transport&)>& body);

}  // namespace weft::engine

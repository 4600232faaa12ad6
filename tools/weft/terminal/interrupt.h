// Signals as requests: at Ctrl-C the run ends soon with the valid mesh it has (a second one kills as usual),
// at SIGUSR1 it says how far it is, at SIGUSR2 it writes a checkpoint.
#pragma once

#include <atomic>

namespace weft::tools {

/// While one lives, the first SIGINT, SIGTERM or SIGALRM sets a flag instead of killing the process. SIGALRM
/// because mpirun passes it on to all ranks, and kills none; at the others it does a second later.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  std::atomic<bool>* flag() const;
  bool raised() const { return flag()->load(); }
};

/// While one lives, SIGUSR2 sets a flag.
class CheckpointRequest {
 public:
  CheckpointRequest();
  ~CheckpointRequest();
  CheckpointRequest(const CheckpointRequest&) = delete;
  CheckpointRequest& operator=(const CheckpointRequest&) = delete;

  std::atomic<bool>* flag() const;
};

/// While one lives, SIGUSR1 asks for a line on how far the run is.
class StateRequest {
 public:
  StateRequest();
  ~StateRequest();
  StateRequest(const StateRequest&) = delete;
  StateRequest& operator=(const StateRequest&) = delete;

  /// Whether somebody has asked since the last call.
  bool take();
};

}  // namespace weft::tools

// Signals as requests: at Ctrl-C the run ends soon with the valid mesh it has (a second one kills as usual),
// at SIGUSR1 it says how far it is.
#pragma once

#include <atomic>

namespace weft::tools {

/// While one lives, the first SIGINT or SIGTERM sets a flag instead of killing the process.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  std::atomic<bool>* flag() const;
  bool raised() const { return flag()->load(); }
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

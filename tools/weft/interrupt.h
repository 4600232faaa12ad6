// Ctrl-C as a request: the run ends soon with the valid mesh it has; a second one kills as usual.
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

  const std::atomic<bool>* flag() const;
  bool raised() const { return flag()->load(); }
};

}  // namespace weft::tools

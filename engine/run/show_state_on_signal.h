// SIGUSR1 shows what a rank does.
#pragma once

#include <csignal>

#include "engine/run/runtime.h"

namespace weft::engine {

/// While it lives, SIGUSR1 calls Runtime::request_state() on this rank. One at a time in a process. mpirun
/// passes the signal on to all ranks.
class ShowStateOnSignal {
 public:
  explicit ShowStateOnSignal(Runtime& runtime);
  ~ShowStateOnSignal();
  ShowStateOnSignal(const ShowStateOnSignal&) = delete;
  ShowStateOnSignal& operator=(const ShowStateOnSignal&) = delete;

 private:
  struct sigaction before_;
};

}  // namespace weft::engine

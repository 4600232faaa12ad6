// SIGTERM and SIGINT end a run in good order.
#pragma once

#include <csignal>

#include "engine/run/runtime.h"

namespace weft::engine {

/// While it lives, the first SIGTERM or SIGINT stops the runtime on all ranks; a second one does what it did
/// before. One at a time in a process.
class StopOnSignal {
 public:
  explicit StopOnSignal(Runtime& runtime);
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  struct sigaction term_before_;
  struct sigaction int_before_;
};

}  // namespace weft::engine

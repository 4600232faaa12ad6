// A handler that does nothing but set a flag and wake the communication thread.
#include "engine/run/show_state_on_signal.h"

#include <atomic>

namespace weft::engine {
namespace {

std::atomic<Runtime*> runtime_to_show{nullptr};

void show_runtime(int) {
  if (Runtime* runtime = runtime_to_show) runtime->request_state();
}

}  // namespace

ShowStateOnSignal::ShowStateOnSignal(Runtime& runtime) {
  runtime_to_show = &runtime;
  struct sigaction action = {};
  action.sa_handler = show_runtime;
  action.sa_flags = SA_RESTART;
  sigaction(SIGUSR1, &action, &before_);
}

ShowStateOnSignal::~ShowStateOnSignal() {
  sigaction(SIGUSR1, &before_, nullptr);
  runtime_to_show = nullptr;
}

}  // namespace weft::engine

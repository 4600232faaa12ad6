// A handler that does nothing but set a flag and wake the communication thread.
#include "engine/run/show_state_on_signal.h"

#include <atomic>
#include <thread>

namespace weft::engine {
namespace {

std::atomic<Runtime*> runtime_to_show{nullptr};
std::atomic<int> handlers{0};  ///< that run just now, on any thread

void show_runtime(int) {
  ++handlers;
  if (Runtime* runtime = runtime_to_show) runtime->request_state();
  --handlers;
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
  while (handlers > 0) std::this_thread::yield();  // the runtime may go when none has it any more
}

}  // namespace weft::engine

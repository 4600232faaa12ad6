// Handlers that do nothing but set a flag and wake the communication thread.
#include "engine/run/stop_on_signal.h"

#include <atomic>

namespace weft::engine {
namespace {

std::atomic<Runtime*> runtime_to_stop{nullptr};

void stop_runtime(int signal) {
  if (Runtime* runtime = runtime_to_stop) {
    runtime->request_stop(signal == SIGINT ? "interrupted (SIGINT)" : "stopped from outside (SIGTERM)");
  }
}

}  // namespace

StopOnSignal::StopOnSignal(Runtime& runtime) {
  runtime_to_stop = &runtime;
  struct sigaction action = {};
  action.sa_handler = stop_runtime;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGTERM, &action, &term_before_);
  sigaction(SIGINT, &action, &int_before_);
}

StopOnSignal::~StopOnSignal() {
  sigaction(SIGTERM, &term_before_, nullptr);
  sigaction(SIGINT, &int_before_, nullptr);
  runtime_to_stop = nullptr;
}

}  // namespace weft::engine

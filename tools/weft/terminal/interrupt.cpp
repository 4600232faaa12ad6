// The signal handlers; their flags are the only globals of the command, because a handler can reach nothing
// else.
#include "tools/weft/terminal/interrupt.h"

#include <csignal>

namespace weft::tools {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

std::atomic<bool> state_wanted = false;
std::atomic<bool> checkpoint_wanted = false;

extern "C" void request_end(int) { interrupted.store(true); }
extern "C" void request_state(int) { state_wanted.store(true); }
extern "C" void request_checkpoint(int) { checkpoint_wanted.store(true); }

void install(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;  // the second signal kills
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGALRM, &action, nullptr);
}

void install_request(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted.store(false);
  install(request_end);
}

InterruptGuard::~InterruptGuard() { install(SIG_DFL); }

std::atomic<bool>* InterruptGuard::flag() const { return &interrupted; }

StateRequest::StateRequest() { install_request(SIGUSR1, request_state); }

StateRequest::~StateRequest() { std::signal(SIGUSR1, SIG_DFL); }

bool StateRequest::take() { return state_wanted.exchange(false); }

CheckpointRequest::CheckpointRequest() {
  checkpoint_wanted.store(false);
  install_request(SIGUSR2, request_checkpoint);
}

CheckpointRequest::~CheckpointRequest() { std::signal(SIGUSR2, SIG_DFL); }

std::atomic<bool>* CheckpointRequest::flag() const { return &checkpoint_wanted; }

}  // namespace weft::tools

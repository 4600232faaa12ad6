// A program for death_test.py: every rank works, the way that the command line says, until something happens
// to it.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/run/launch.h"
#include "engine/run/runtime.h"
#include "engine/run/show_state_on_signal.h"

using namespace weft::engine;

std::atomic<Runtime*> runtime_to_stop{nullptr};

void stop_runtime(int) {
  if (Runtime* runtime = runtime_to_stop) runtime->request_stop("stopped from outside (SIGTERM)");
}

/// While it is there SIGTERM stops the runtime; when that is gone, the signal does nothing.
class StopsOnSignal {
 public:
  explicit StopsOnSignal(Runtime& runtime) {
    runtime_to_stop = &runtime;
    std::signal(SIGTERM, stop_runtime);
  }
  ~StopsOnSignal() { runtime_to_stop = nullptr; }
};

void say_who(Context& context) {
  std::printf("rank %d is process %d\n", context.rank().value, static_cast<int>(getpid()));
  std::fflush(stdout);
}

struct Victim {
  void last(Context& context) {
    say_who(context);
    while (!context.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void be_deaf(Context& context) {
    say_who(context);
    std::this_thread::sleep_for(std::chrono::minutes(1));
  }
  void flood(Context& context) {
    say_who(context);
    const MobilePtr<Victim> next{{Rank((context.rank().value + 1) % context.ranks()), 1}};
    while (!context.stop_requested()) context.invoke<&Victim::take>(next, std::vector<double>(200'000));
  }
  void take(Context&, const std::vector<double>&) {}
};

/// The ways: last, deaf, flood, fail; system COMMAND: start another program, as a solver would; and "apart"
/// before one of them: as if each rank were on a node of its own. A rank is silent for too long after a
/// second.
int main(int argc, char** argv) {
  const bool apart = argc > 1 && std::string(argv[1]) == "apart";
  argv += apart ? 1 : 0;
  argc -= apart ? 1 : 0;
  const std::string way = argc > 1 ? argv[1] : "last";
  const auto body = [&](Transport& transport) {
    if (way == "system") return std::system(argv[2]) == 0 ? 0 : 1;
    Registry registry;
    registry.type<Victim>("Victim")
        .method<&Victim::last>("last")
        .method<&Victim::be_deaf>("be_deaf")
        .method<&Victim::flood>("flood")
        .method<&Victim::take>("take");
    Runtime runtime(transport, registry,
                    {.silence = std::chrono::seconds(3), .grace = std::chrono::seconds(2)});
    const StopsOnSignal stops(runtime);
    const ShowStateOnSignal show(runtime);
    runtime.run([&](Context& context) {
      const auto victim = context.create<Victim>();
      if (way == "deaf") {
        context.invoke<&Victim::be_deaf>(victim);
      } else if (way == "flood") {
        context.invoke<&Victim::flood>(victim);
      } else {
        context.invoke<&Victim::last>(victim);
      }
      if (way == "fail" && context.rank() == Rank(context.ranks() - 1)) {
        throw std::runtime_error("I was asked to");
      }
    });
    return 0;
  };
  return launch(argc, argv, body, {.shared_memory = !apart});
}

// A program for death_test.py: every rank works, the way that the command line says, until something happens
// to it.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>

#include "engine/launch.h"
#include "engine/runtime.h"

using namespace weft::engine;

struct Victim {
  void last(Context& context) {
    std::printf("rank %d is process %d\n", context.rank().value, static_cast<int>(getpid()));
    std::fflush(stdout);
    while (!context.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void fail(Context&) { throw std::runtime_error("I was asked to"); }
};

int main(int argc, char** argv) {
  const std::string way = argc > 1 ? argv[1] : "last";
  return launch(argc, argv, [&](Transport& transport) {
    Registry registry;
    registry.type<Victim>("Victim").method<&Victim::last>("last").method<&Victim::fail>("fail");
    Runtime runtime(transport, registry);
    const StopOnSignal stop(runtime);
    runtime.run([&](Context& context) {
      if (way == "end") return;
      context.invoke<&Victim::last>(context.create<Victim>());
      if (way == "fail" && context.rank() == Rank(context.ranks() - 1)) {
        throw std::runtime_error("I was asked to");
      }
    });
    return 0;
  });
}

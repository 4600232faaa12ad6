// A program for death_test.py: every rank works, the way that the command line says, until something happens
// to it.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/run/launch.h"
#include "engine/run/runtime.h"
#include "engine/run/show_state_on_signal.h"
#include "engine/run/stop_on_signal.h"

using namespace weft::engine;

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

int main(int argc, char** argv) {
  const std::string way = argc > 1 ? argv[1] : "last";
  return launch(argc, argv, [&](Transport& transport) {
    Registry registry;
    registry.type<Victim>("Victim")
        .method<&Victim::last>("last")
        .method<&Victim::be_deaf>("be_deaf")
        .method<&Victim::flood>("flood")
        .method<&Victim::take>("take");
    Runtime runtime(transport, registry, {.grace = std::chrono::seconds(2)});
    const StopOnSignal stop(runtime);
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
  });
}

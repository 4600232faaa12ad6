// Clocks by the system's calls; gathering by the engine itself.
#include "tools/bench/engine/measures.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <fstream>
#include <string>

#include "engine/run/runtime.h"

namespace weft::bench {
namespace {

double read_clock(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

/// Few enough steps that reading the clock between them, a system call, does not dominate: about 10 us.
constexpr std::uint64_t kStepsPerLook = 10'000;

std::atomic<std::uint64_t> sink;

struct Collector {
  std::vector<std::vector<double>> numbers;

  void add(engine::Context&, int rank, std::vector<double> theirs) {
    numbers.resize(std::max(numbers.size(), static_cast<std::size_t>(rank) + 1));
    numbers[static_cast<std::size_t>(rank)] = std::move(theirs);
  }
};

}  // namespace

double wall_clock() { return read_clock(CLOCK_MONOTONIC); }
double thread_cpu() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu() { return read_clock(CLOCK_PROCESS_CPUTIME_ID); }

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(place, values.size() - 1)];
}

void work(std::uint64_t steps) {
  std::uint64_t x = steps;
  for (std::uint64_t i = 0; i < steps; ++i) x = x * 6364136223846793005u + 1442695040888963407u;
  sink.store(x, std::memory_order_relaxed);  // or the compiler would leave the loop out
}

double steps_per_second() {
  std::vector<double> rates;
  for (int i = 0; i < 21; ++i) {
    const std::uint64_t steps = 2'000'000;
    const double begin = thread_cpu();
    work(steps);
    rates.push_back(static_cast<double>(steps) / (thread_cpu() - begin));
  }
  return median(rates);
}

void work_for(double seconds) {
  const double end = thread_cpu() + seconds;
  while (thread_cpu() < end) work(kStepsPerLook);
}

double machine_cpu() {
  std::ifstream file("/proc/stat");
  std::string name;
  double user = 0, nice = 0, system = 0;
  file >> name >> user >> nice >> system;
  return (user + nice + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

std::vector<std::vector<double>> gather(engine::Transport& transport, std::vector<double> mine) {
  engine::Registry registry;
  registry.type<Collector>("Collector").method<&Collector::add>("add");
  engine::Runtime runtime(transport, registry, {.balancer = engine::no_balancing()});
  const engine::MobilePtr<Collector> collector{{engine::Rank(0), 1}};
  runtime.run([&](engine::Context& context) {
    if (context.rank() == engine::Rank(0)) context.create<Collector>();
    context.invoke<&Collector::add>(collector, context.rank().value, std::move(mine));
  });
  std::vector<std::vector<double>> all;
  runtime.visit<Collector>(
      [&](engine::MobilePtr<Collector>, Collector& found) { all = std::move(found.numbers); });
  return all;
}

}  // namespace weft::bench

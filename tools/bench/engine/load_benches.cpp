// Benchmarks of whole runs: balancing, tracing, waiting.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <thread>
#include <vector>

#include "engine/json/json.h"
#include "engine/run/runtime.h"
#include "tools/bench/engine/benches.h"
#include "tools/bench/engine/measures.h"

namespace weft::bench {
namespace {

using engine::Context;
using engine::MobilePtr;
using engine::Rank;
using engine::Registry;
using engine::Runtime;
using engine::Seconds;
using engine::Transport;

// --- Balancing

constexpr int kDomains = 256;
constexpr double kTotalWork = 14;  ///< CPU seconds in all
constexpr double kTail = 1.2;  ///< sigma of the log-normal costs: a tenth of the objects has half the work
constexpr double kMostOfMean = 16;        ///< where the tail is cut: no object may be a bottleneck of its own
constexpr double kSwing = 1.0;            ///< costs of an object grow and shrink by e^kSwing
constexpr double kPredictionError = 0.3;  ///< sigma of the log of expected / true seconds
constexpr std::size_t kStateBytes = 16 << 10;

/// One task of an object.
struct Job {
  double seconds = 0;   ///< CPU time it takes
  double expected = 0;  ///< what the engine is told
};

/// Does its jobs one after the other, wherever it is.
struct Domain {
  std::vector<Job> jobs;
  std::vector<std::uint8_t> state;
  double steps_per_second = 0;
  double cpu = 0;
  std::uint64_t done = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(jobs, state, steps_per_second, cpu, done);
  }
  void next(Context& context) {
    const double begin = thread_cpu();
    work(static_cast<std::uint64_t>(jobs[done].seconds * steps_per_second));
    cpu += thread_cpu() - begin;
    if (++done == jobs.size()) return;
    context.invoke_expecting<&Domain::next>(Seconds{jobs[done].expected}, MobilePtr<Domain>{context.self()});
  }
};

/// Between 20 and 40 jobs whose costs are one wave, a bump that begins anywhere.
std::vector<Job> jobs_of_one(double cost, std::mt19937_64& random) {
  const int count = std::uniform_int_distribution<int>(20, 40)(random);
  const double phase = std::uniform_real_distribution<double>(0, 2 * std::numbers::pi)(random);
  std::lognormal_distribution<double> error(0, kPredictionError);
  std::vector<Job> jobs;
  for (int i = 0; i < count; ++i) {
    const double wave = std::exp(kSwing * std::sin(phase + 2 * std::numbers::pi * i / count));
    jobs.push_back({cost * wave / count, 0});
    jobs.back().expected = jobs.back().seconds * error(random);
  }
  return jobs;
}

/// The same in every run.
std::vector<std::vector<Job>> jobs_of_all() {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> cost(-kTail * kTail / 2, kTail);  // of mean 1
  std::vector<std::vector<Job>> all;
  double sum = 0;
  for (int i = 0; i < kDomains; ++i) {
    all.push_back(jobs_of_one(std::min(cost(random), kMostOfMean), random));
    for (const Job& job : all.back()) sum += job.seconds;
  }
  for (auto& jobs : all) {
    for (Job& job : jobs) job.seconds *= kTotalWork / sum, job.expected *= kTotalWork / sum;
  }
  return all;
}

double longest_chain() {
  double longest = 0;
  for (const auto& jobs : jobs_of_all()) {
    double sum = 0;
    for (const Job& job : jobs) sum += job.seconds;
    longest = std::max(longest, sum);
  }
  return longest;
}

void start_domains(Context& context, double speed) {
  for (auto& jobs : jobs_of_all()) {
    const Seconds expected{jobs[0].expected};
    const auto domain = context.create<Domain>(
        Domain{std::move(jobs), std::vector<std::uint8_t>(kStateBytes, 1), speed, 0, 0});
    context.invoke_expecting<&Domain::next>(expected, domain);
  }
}

/// Sums over ranks of what they say, by place.
std::vector<double> sums(const std::vector<std::vector<double>>& numbers) {
  std::vector<double> result(numbers.empty() ? 0 : numbers[0].size());
  for (const auto& row : numbers) std::ranges::transform(row, result, result.begin(), std::plus<>());
  return result;
}

// --- Tracing

constexpr int kTasks = 300;
constexpr double kTaskSeconds = 1e-3;

struct Ticker {
  void tick(Context& context, int left) {
    work_for(kTaskSeconds);
    if (left > 1) context.invoke<&Ticker::tick>(MobilePtr<Ticker>{context.self()}, left - 1);
  }
};

struct TaskCost {
  double wall, cpu;  ///< seconds for one task
};

TaskCost tick(Transport& transport, bool spans) {
  Registry registry;
  registry.type<Ticker>("Ticker").method<&Ticker::tick>("tick");
  Runtime runtime(transport, registry, {.trace = {.spans = spans}});
  const double wall = wall_clock(), cpu = process_cpu();
  runtime.run([](Context& context) { context.invoke<&Ticker::tick>(context.create<Ticker>(), kTasks); });
  return {(wall_clock() - wall) / kTasks, (process_cpu() - cpu) / kTasks};
}

// --- Waiting

constexpr double kSleepSeconds = 3;

struct Sleeping {
  void sleep(Context&) { std::this_thread::sleep_for(std::chrono::duration<double>(kSleepSeconds)); }
};

}  // namespace

ordered_json balance(Transport& transport, const std::string& policy) {
  Registry registry;
  registry.type<Domain>("Domain").method<&Domain::next>("next");
  Runtime runtime(transport, registry, {.threads = 1, .balancer = engine::balancer_by_name(policy)});
  const double speed = transport.rank() == Rank(0) ? steps_per_second() : 0;
  const double machine = machine_cpu(), process = process_cpu(), begin = wall_clock();
  runtime.run([&](Context& context) {
    if (context.rank() == Rank(0)) start_domains(context, speed);
  });
  const double wall = wall_clock() - begin, process_used = process_cpu() - process;
  const double machine_used = machine_cpu() - machine;
  double handlers = 0, done = 0;
  runtime.visit<Domain>([&](MobilePtr<Domain>, Domain& domain) {
    handlers += domain.cpu;
    done += static_cast<double>(domain.done);
  });
  const engine::RankSummary summary = runtime.summary();
  const double moved = static_cast<double>(summary.migrations().received.messages);
  const auto all = gather(transport, {handlers, done, process_used, moved, summary.times.compute});
  if (transport.rank() != Rank(0)) return {};
  const std::vector<double> sum = sums(all);
  const int cores = std::min(static_cast<int>(std::thread::hardware_concurrency()), transport.size());
  const double ideal = sum[0] / cores;
  ordered_json compute;
  for (const auto& row : all) compute.push_back(row[4]);
  return {{"policy", policy},
          {"objects", kDomains},
          {"tasks", sum[1]},
          {"ranks", transport.size()},
          {"wall", wall},
          {"work", sum[0]},
          {"ideal", ideal},
          {"ratio", wall / ideal},
          {"migrations", sum[3]},
          {"longest_chain", longest_chain()},
          {"process_cpu", sum[2]},
          {"other_programs_cpu", std::max(0.0, machine_used - sum[2])},
          {"compute_by_rank", compute}};
}

ordered_json trace(Transport& transport) {
  std::vector<double> wall[2], cpu[2];
  for (int turn = -1; turn < 10; ++turn) {  // the first warms up
    TaskCost costs[2];
    for (const int i : {0, 1}) {
      const bool spans = (i + turn) % 2 != 0;  // who goes first alternates, too
      costs[spans] = tick(transport, spans);
    }
    if (turn < 0) continue;
    for (const int spans : {0, 1}) {
      wall[spans].push_back(costs[spans].wall);
      cpu[spans].push_back(costs[spans].cpu);
    }
  }
  return {{"task_s", kTaskSeconds},
          {"cpu_ratio", 1 + (median(cpu[1]) - median(cpu[0])) / kTaskSeconds},
          {"wall_ratio", std::ranges::min(wall[1]) / std::ranges::min(wall[0])},
          {"cpu_us_off", median(cpu[0]) * 1e6},
          {"cpu_us_on", median(cpu[1]) * 1e6},
          {"wall_us_off", std::ranges::min(wall[0]) * 1e6},
          {"wall_us_on", std::ranges::min(wall[1]) * 1e6}};
}

ordered_json idle(Transport& transport) {
  Registry registry;
  registry.type<Sleeping>("Sleeping").method<&Sleeping::sleep>("sleep");
  ordered_json result;
  for (const char* policy : {"none", "stealing", "diffusion"}) {
    Runtime runtime(transport, registry, {.balancer = engine::balancer_by_name(policy)});
    const double cpu = process_cpu(), begin = wall_clock();
    runtime.run([](Context& context) {
      if (context.rank() == Rank(0)) context.invoke<&Sleeping::sleep>(context.create<Sleeping>());
    });
    const double wall = wall_clock() - begin, used = process_cpu() - cpu;
    double most = 0, sum = 0;
    const auto all = gather(transport, {100 * used / wall});
    for (std::size_t rank = 1; rank < all.size(); ++rank)
      most = std::max(most, all[rank][0]), sum += all[rank][0];
    if (all.empty()) continue;
    result.push_back({{"policy", policy},
                      {"idle_ranks", transport.size() - 1},
                      {"wall", wall},
                      {"most_percent_of_core", most},
                      {"mean_percent_of_core", sum / std::max(1, transport.size() - 1)}});
  }
  return result;
}

}  // namespace weft::bench

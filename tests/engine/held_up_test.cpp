// What threads wait for a processor that others have, and that handlers are not judged by it.
#include "engine/trace/held_up.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "engine/run/runtime.h"
#include "engine/trace/processor_time.h"
#include "tests/support/ranks.h"

namespace weft::engine::held_up_test {
namespace {

using weft::testing::on_ranks;

constexpr TimePoint kMillisecond = 1'000'000;

void work(TimePoint nanoseconds) {
  const TimePoint begin = processor_time();
  while (processor_time() - begin < nanoseconds) continue;
}

/// Where it does not, it says that threads have had nothing of a processor either.
bool system_tells() {
  TimePoint had = 0;
  std::ifstream("/proc/thread-self/schedstat") >> had;
  return had > 0;
}
constexpr const char* kUntold = "this system does not say how long threads wait for a processor";

/// While it lives, this thread and those that it starts have one processor, which another thread keeps busy.
class CrowdedProcessor {
 public:
  CrowdedProcessor() {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
      if (CPU_ISSET(cpu, &before_)) CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof one, &one);
    other_ = std::thread([this] {
      while (!done_) continue;
    });
  }
  ~CrowdedProcessor() {
    done_ = true;
    other_.join();
    sched_setaffinity(0, sizeof before_, &before_);
  }

 private:
  cpu_set_t before_;
  std::atomic<bool> done_{false};
  std::thread other_;
};

/// Seconds of the wall and held up while this thread works for 100 ms.
std::pair<double, double> while_crowded() {
  const CrowdedProcessor crowded;
  HeldUpClock clock;
  const TimePoint begin = now(), before = clock.until(begin);
  work(100 * kMillisecond);
  const TimePoint end = now(), after = clock.until(end);
  return {1e-9 * static_cast<double>(end - begin), 1e-9 * static_cast<double>(after - before)};
}

TEST(HeldUp, IsWhatOthersHaveTheProcessor) {
  if (!system_tells()) GTEST_SKIP() << kUntold;
  const auto [wall, held_up] = while_crowded();
  EXPECT_GT(wall, 0.13) << "the other thread had nothing of the processor";
  EXPECT_NEAR(wall - held_up, 0.1, 0.03);
}

TEST(HeldUp, IsNotWhatAThreadSleeps) {
  HeldUpClock clock;
  const TimePoint before = clock.until(now());
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_LT(clock.until(now()) - before, 50 * kMillisecond);
}

struct Worker {
  void run(Context&) { work(40 * kMillisecond); }
  template <class Archive>
  void serialize(Archive&) {}
};

/// Notes what objects that wait are expected to take.
class Observer final : public Balancer {
 public:
  explicit Observer(double& most) : most_(most) {}
  void step(BalanceActions& actions, TimePoint) override {
    actions.wake_when_ready(true);
    for (const ReadyObject& object : actions.ready_objects()) most_ = std::max(most_, object.seconds);
  }
  void told(Rank, const BalanceMessage&, BalanceActions&) override {}

 private:
  double& most_;
};

TEST(HeldUp, HandlersAreJudgedByWhatTheyTakeWithout) {
  if (!system_tells()) GTEST_SKIP() << kUntold;
  const CrowdedProcessor crowded;
  double expected = 0;
  TimePoint wall = 0;
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    registry.type<Worker>("Worker").method<&Worker::run>("run");
    Runtime runtime(transport, registry, {.threads = 1, .balancer = [&](Rank, int) {
                                            return std::make_unique<Observer>(expected);
                                          }});
    std::vector<MobilePtr<Worker>> workers;
    const auto run = [&] {
      runtime.run([&](Context& context) {
        if (workers.empty()) workers = {context.create<Worker>(), context.create<Worker>()};
        for (const auto& worker : workers) context.invoke<&Worker::run>(worker);
      });
    };
    const TimePoint begin = now();
    run();
    wall = now() - begin;
    run();
  });
  EXPECT_GT(wall, 110 * kMillisecond) << "the other thread had nothing of the processor";
  EXPECT_NEAR(expected, 0.04, 0.015);
}

}  // namespace
}  // namespace weft::engine::held_up_test

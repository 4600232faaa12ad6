// Programs of the engine on simulated ranks: the real protocols, virtual time.
#include "engine/simulate/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/run/runtime.h"

namespace weft::engine::simulation_test {
namespace {

using ::testing::HasSubstr;

constexpr TimePoint kMillisecond = 1'000'000;
constexpr int kHops = 20;

/// Work that takes its time on the virtual clock.
struct Chunk {
  std::int64_t nanoseconds = 0;
  int done = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(nanoseconds, done);
  }
  void work(Context&, std::int64_t how_long) {
    VirtualTime::of_thread()->spend(how_long);
    ++done;
  }
};

/// Adds up what all others tell it, in an event.
struct Sum {
  std::uint64_t total = 0;
  std::uint64_t arrived = 0;

  void tell(Context& context) {
    if (context.rank() == Rank(0)) {
      std::vector<ObjectId> all;
      for (int r = 0; r < context.ranks(); ++r) all.push_back({Rank(r), 1});
      context.expect<&Sum::gather>(1, all);
    }
    const auto value = static_cast<std::uint64_t>(context.rank().value);
    context.signal<&Sum::gather>(MobilePtr<Sum>{{Rank(0), 1}}, 1, value);
  }
  void gather(Context&, std::uint64_t, std::vector<Arrival<std::uint64_t>> values) {
    arrived += values.size();
    for (const auto& value : values) total += value.value;
  }
};

struct Bad {
  void fail(Context&) { throw std::runtime_error("on purpose"); }
};

struct Waiter {
  void begin(Context& context) { context.expect<&Waiter::gather>(1, {ObjectId{Rank(0), 99}}); }
  void gather(Context&, std::uint64_t, std::vector<Arrival<std::uint64_t>>) {}
};

/// Passes a token round a ring of ranks.
struct Ring {
  int visits = 0;
  void pass(Context& context, int hops) {
    ++visits;
    if (hops == 0) return;
    const Rank next((context.rank().value + 1) % context.ranks());
    context.invoke<&Ring::pass>(MobilePtr<Ring>{{next, 1}}, hops - 1);
  }
};

SimulationOptions given(int ranks) {
  SimulationOptions options;
  options.ranks = ranks;
  options.measured = false;
  options.stack_bytes = 256 << 10;
  return options;
}

/// `chunks` of a millisecond on rank 0; what each rank has done in the end.
std::vector<int> done_by_rank(int ranks, int chunks, const BalancerFactory& balancer,
                              SimulationResult& result) {
  std::vector<int> done(static_cast<std::size_t>(ranks));
  result = simulate(given(ranks), [&](Transport& transport) {
    Registry registry;
    registry.type<Chunk>("Chunk").method<&Chunk::work>("work");
    Runtime runtime(transport, registry, {.threads = 1, .balancer = balancer});
    runtime.run([&](Context& context) {
      if (context.rank() != Rank(0)) return;
      for (int i = 0; i < chunks; ++i)
        context.invoke_expecting<&Chunk::work>(Seconds{1e-3}, context.create<Chunk>(), kMillisecond);
    });
    runtime.visit<Chunk>(
        [&](MobilePtr<Chunk>, Chunk& chunk) { done[transport.rank().index()] += chunk.done; });
  });
  return done;
}

TEST(Simulation, A_message_takes_the_latency_of_the_network) {
  SimulationOptions options = given(2);
  options.network = {.latency = 1e-3, .bandwidth = 1e9, .gap = 0, .overhead = 0};
  const SimulationResult result = simulate(options, [](Transport& transport) {
    Registry registry;
    registry.type<Ring>("Ring").method<&Ring::pass>("pass");
    Runtime runtime(transport, registry, {.threads = 1, .balancer = no_balancing()});
    runtime.run([&](Context& context) {
      const auto ring = context.create<Ring>();
      if (context.rank() == Rank(0)) context.invoke<&Ring::pass>(ring, kHops);
    });
    runtime.visit<Ring>([](MobilePtr<Ring>, Ring& ring) { EXPECT_GE(ring.visits, kHops / 2); });
  });
  EXPECT_GE(result.seconds, kHops * 1e-3);
  EXPECT_LT(result.seconds, kHops * 1e-3 + 0.02);  // and the waves that find the end
}

TEST(Simulation, A_large_message_takes_the_time_that_the_bandwidth_gives) {
  NetworkLinks links({.latency = 1e-6, .bandwidth = 1e9, .gap = 0, .overhead = 0}, 3);
  EXPECT_EQ(links.send(Rank(0), Rank(1), 1'000'000, 0), 1'001'000);
  EXPECT_EQ(links.send(Rank(0), Rank(2), 1'000'000, 0), 2'001'000) << "the port sends one after the other";
  EXPECT_EQ(links.send(Rank(2), Rank(1), 1'000'000, 0), 2'001'000) << "and receives so";
}

TEST(Simulation, Switches_share_their_uplinks) {
  const NetworkModel model{.latency = 1e-6,
                           .bandwidth = 1e9,
                           .gap = 0,
                           .overhead = 0,
                           .topology = Topology::tree,
                           .switch_ranks = 4};
  NetworkLinks links(model, 8);
  const auto near = links.send(Rank(0), Rank(1), 1'000'000, 0);
  std::int64_t last = 0;
  NetworkLinks far(model, 8);
  for (int r = 0; r < 4; ++r) last = std::max(last, far.send(Rank(r), Rank(r + 4), 1'000'000, 0));
  EXPECT_EQ(near, 1'001'000);
  EXPECT_GE(last, 2'000'000) << "four ports of 1 GB/s share an uplink of 2 GB/s";
}

TEST(Simulation, Networks_are_read_from_words) {
  const NetworkModel network = parse_network("50us,1GB/s,tree:16");
  EXPECT_DOUBLE_EQ(network.latency, 50e-6);
  EXPECT_DOUBLE_EQ(network.bandwidth, 1e9);
  EXPECT_EQ(network.topology, Topology::tree);
  EXPECT_EQ(network.switch_ranks, 16);
  EXPECT_EQ(parse_network("2us,10GB/s,fat-tree:8").topology, Topology::fat_tree);
  EXPECT_EQ(parse_network("2us,10GB/s,dragonfly:4").topology, Topology::dragonfly);
  EXPECT_EQ(parse_network("2us,10GB/s,dragonfly:4").switch_ranks, 4);
  EXPECT_EQ(parse_network("2us,10GB/s,flat").topology, Topology::flat);
  EXPECT_DOUBLE_EQ(parse_network("2e-6,1e10").bandwidth, 1e10);
  for (const char* bad :
       {"", "2us", "2us,10GB/s,ring", "-1us,1GB/s", "2us,fast", "2us,1GB/s,tree:0", "2us,1GB/s,dragonfly",
        "2us,1GB/s,fat-tree:4x", "2us,1GB/s,flat,4", "1e9s,1GB/s", "2us,1B/s", "2us,1e30GB/s",
        "2us,1GB/s,tree:2000000000", "2us,1GB/s,fat-tree:2000000000"})
    EXPECT_THROW(parse_network(bad), std::invalid_argument) << bad;
}

TEST(Simulation, Work_that_cannot_move_is_done_one_after_the_other_and_by_all_where_it_can) {
  SimulationResult alone, shared;
  const std::vector<int> stayed = done_by_rank(4, 64, no_balancing(), alone);
  EXPECT_EQ(stayed[0], 64);
  EXPECT_NEAR(alone.seconds, 0.064, 0.002);
  const std::vector<int> moved = done_by_rank(4, 64, work_stealing(), shared);
  EXPECT_EQ(std::accumulate(moved.begin(), moved.end(), 0), 64);
  EXPECT_GT(*std::min_element(moved.begin(), moved.end()), 4);
  EXPECT_LT(shared.seconds, 0.7 * alone.seconds);
}

/// Rank r does r + 1 chunks of a millisecond; when each has done its own.
std::vector<TimePoint> ends_on(int cores, int ranks) {
  std::vector<TimePoint> ends(static_cast<std::size_t>(ranks));
  SimulationOptions options = given(ranks);
  options.cores = cores;
  options.handler_overhead = 0;
  simulate(options, [&](Transport& transport) {
    Registry registry;
    registry.type<Chunk>("Chunk").method<&Chunk::work>("work");
    Runtime runtime(transport, registry,
                    {.threads = 1, .balancer = no_balancing(), .trace = {.spans = true}});
    runtime.run([&](Context& context) {
      const auto chunk = context.create<Chunk>();
      for (int i = 0; i <= context.rank().value; ++i) context.invoke<&Chunk::work>(chunk, kMillisecond);
    });
    for (const RankTimeline& rank : runtime.gather_timelines())
      for (const auto& lane : rank.lanes)
        for (const Span& span : lane.spans)
          if (span.activity == Activity::compute)
            ends[rank.rank.index()] = std::max(ends[rank.rank.index()], span.end);
  });
  return ends;
}

TEST(Simulation, Ranks_that_share_cores_get_on_at_one_rate_and_faster_when_some_are_through) {
  const auto is_about = [](TimePoint end, double milliseconds) {
    EXPECT_NEAR(static_cast<double>(end) / kMillisecond, milliseconds, 0.01);
  };
  const std::vector<TimePoint> own = ends_on(0, 4), shared = ends_on(2, 4);
  for (int r = 0; r < 4; ++r) is_about(own[static_cast<std::size_t>(r)], r + 1);
  is_about(shared[0], 2);    // all four at half the rate
  is_about(shared[1], 3.5);  // three at two thirds
  is_about(shared[2], 4.5);  // two cores for two
  is_about(shared[3], 5.5);
}

/// When the communication thread of rank 1 goes on that sleeps for a millisecond, while rank 0 works.
TimePoint goes_on_with(int cores) {
  SimulationOptions options = given(2);
  options.cores = cores;
  options.core_wait = 0.5e-3;
  TimePoint goes_on = 0;
  simulate(options, [&](Transport& transport) {
    VirtualTime& time = *transport.virtual_time();
    if (transport.rank() == Rank(0)) {
      time.workers_run(1);
      transport.wait(std::chrono::milliseconds(10));
      time.workers_run(-1);
    } else {
      do transport.wait(std::chrono::milliseconds(1));
      while (!time.communicates());
      goes_on = time.now();
    }
  });
  return goes_on;
}

TEST(Simulation, Communication_threads_wait_for_a_core_where_workers_have_all) {
  EXPECT_EQ(goes_on_with(1), 3 * kMillisecond / 2);
  EXPECT_EQ(goes_on_with(2), kMillisecond);
  EXPECT_EQ(goes_on_with(0), kMillisecond);
}

TEST(Simulation, Every_balancer_spreads_work_over_a_thousand_ranks) {
  for (const char* name : {"stealing", "diffusion"}) {
    SimulationResult result;
    const std::vector<int> done = done_by_rank(1024, 4096, balancer_by_name(name), result);
    EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), 4096) << name;
    EXPECT_GT(std::count_if(done.begin(), done.end(), [](int n) { return n > 0; }), 512) << name;
  }
}

TEST(Simulation, The_same_simulation_takes_the_same_turns_and_time) {
  SimulationResult first, second;
  const auto a = done_by_rank(37, 500, work_stealing(), first);
  const auto b = done_by_rank(37, 500, work_stealing(), second);
  EXPECT_EQ(a, b);
  EXPECT_EQ(first.seconds, second.seconds);
  EXPECT_EQ(first.turns, second.turns);
  EXPECT_EQ(first.packets, second.packets);
}

TEST(Simulation, An_event_gathers_from_four_thousand_ranks) {
  constexpr std::uint64_t kMany = 4096;
  Sum at_first;
  simulate(given(kMany), [&](Transport& transport) {
    Registry registry;
    registry.type<Sum>("Sum").method<&Sum::tell>("tell").event<&Sum::gather>("gather");
    Runtime runtime(transport, registry, {.threads = 1});
    runtime.run([](Context& context) { context.invoke<&Sum::tell>(context.create<Sum>()); });
    runtime.visit<Sum>([&](MobilePtr<Sum>, Sum& sum) {
      if (transport.rank() == Rank(0)) at_first = sum;
    });
  });
  EXPECT_EQ(at_first.arrived, kMany);
  EXPECT_EQ(at_first.total, kMany * (kMany - 1) / 2);
}

TEST(Simulation, Summaries_of_all_ranks_are_consistent) {
  simulate(given(64), [&](Transport& transport) {
    Registry registry;
    registry.type<Ring>("Ring").method<&Ring::pass>("pass");
    Runtime runtime(transport, registry, {.threads = 1});
    runtime.run([&](Context& context) {
      const auto ring = context.create<Ring>();
      if (context.rank().value % 8 == 0) context.invoke<&Ring::pass>(ring, 100);
    });
    const RunSummary run = merge(runtime.gather_summaries());
    if (transport.rank() != Rank(0)) return;
    EXPECT_TRUE(run.consistent.pairs);
    EXPECT_EQ(run.ranks.size(), 64u);
    EXPECT_EQ(run.counters.at("handlers").sum, 8 * 101);
    EXPECT_EQ(run.peak_rss_sum, 0u) << "that of the process is no rank's";
  });
}

TEST(Simulation, A_handler_that_throws_fails_all_ranks_with_its_name) {
  int failed = 0;
  try {
    simulate(given(100), [&](Transport& transport) {
      Registry registry;
      registry.type<Bad>("Bad").method<&Bad::fail>("fail");
      Runtime runtime(transport, registry, {.threads = 2, .on_failure = {}});
      try {
        runtime.run([&](Context& context) {
          if (context.rank() == Rank(7)) context.invoke<&Bad::fail>(context.create<Bad>());
        });
      } catch (const RunFailure&) {
        ++failed;
        throw;
      }
    });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const RunFailure& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("on purpose"));
    EXPECT_THAT(failure.what(), HasSubstr("rank 7"));
  }
  EXPECT_EQ(failed, 100);
}

TEST(Simulation, A_rank_that_leaves_alone_is_named_by_the_others) {
  try {
    simulate(given(3), [&](Transport& transport) {
      if (transport.rank() == Rank(1)) throw std::runtime_error("no such file");
      Registry registry;
      Runtime runtime(transport, registry, {.threads = 1, .on_failure = {}});
      runtime.run();
    });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("rank 1"));
  }
}

TEST(Simulation, A_run_that_stalls_says_who_waits) {
  try {
    simulate(given(5), [&](Transport& transport) {
      Registry registry;
      registry.type<Waiter>("Waiter").method<&Waiter::begin>("begin").event<&Waiter::gather>("gather");
      Runtime runtime(transport, registry, {.threads = 1, .on_failure = {}});
      runtime.run([&](Context& context) {
        if (context.rank() == Rank(3)) context.invoke<&Waiter::begin>(context.create<Waiter>());
      });
    });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const RunFailure& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("the run has stalled"));
  }
}

/// Of the thread, as the system counts it.
TimePoint processor_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

TEST(Simulation, Measured_time_passes_by_the_processor) {
  SimulationOptions options;
  options.ranks = 2;
  options.slowdown = 3;
  const auto result = simulate(options, [](Transport& transport) {
    Registry registry;
    Runtime runtime(transport, registry, {.threads = 1});
    runtime.run([](Context&) {
      const TimePoint began = processor_time(), begin = now();
      TimePoint worked = 0;
      while (worked < 20 * kMillisecond) worked = processor_time() - began;
      EXPECT_NEAR(static_cast<double>(now() - begin) / static_cast<double>(worked), 3, 0.3);
    });
  });
  EXPECT_GE(result.seconds, 0.9 * 3 * 0.02);
}

TEST(Simulation, Measured_time_is_not_what_the_simulation_takes) {
  constexpr int kTurns = 20'000;
  SimulationOptions options;
  options.ranks = 8;
  TimePoint charged = 0;
  const SimulationResult result = simulate(options, [&](Transport& transport) {
    const TimePoint begin = now();
    for (int i = 0; i < kTurns; ++i) transport.wait(std::chrono::microseconds(1));
    charged += now() - begin - kTurns * 1000;
  });
  EXPECT_GE(result.turns, 8u * kTurns);
  EXPECT_GE(charged, 0);
  EXPECT_LT(1e-9 * static_cast<double>(charged), 0.3 * result.real_seconds) << "in turns without work";
}

TEST(Simulation, A_packet_takes_what_the_model_says_where_the_rest_is_measured) {
  SimulationOptions options;
  options.ranks = 2;
  options.network.overhead = 1e-3;
  simulate(options, [](Transport& transport) {
    if (transport.rank() == Rank(1)) return;
    const TimePoint begin = now();
    for (int i = 0; i < 10; ++i) transport.send(Rank(1), {});
    EXPECT_GE(now() - begin, 10 * kMillisecond);
  });
}

}  // namespace
}  // namespace weft::engine::simulation_test

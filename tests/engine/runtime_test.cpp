// The engine as its users see it, on every number of ranks.
#include "engine/run/runtime.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

#include "engine/trace/processor_time.h"
#include "tests/support/ranks.h"
#include "tests/support/repetitions.h"

namespace weft::engine::runtime_test {
namespace {

using weft::testing::kSlowness;
using weft::testing::on_ranks;

class RuntimeOnRanks : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, RuntimeOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

std::uint64_t mix(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

// --- Counting: objects that add up what they are sent.

struct Counter {
  std::int64_t sum = 0;
  std::int64_t calls = 0;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(sum, calls);
  }
  void add(Context&, std::int64_t amount) {
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) +
                                    static_cast<std::uint64_t>(amount));  // may wrap
    ++calls;
  }
};

Registry counters() {
  Registry registry;
  registry.type<Counter>("Counter").method<&Counter::add>("add");
  return registry;
}

/// The sum over all ranks of what `mine` is on each: rank 0 owns a counter that all know.
std::int64_t sum_over_ranks(Runtime& runtime, std::int64_t mine) {
  const MobilePtr<Counter> total{{Rank(0), 1}};
  runtime.run([&](Context& context) {
    if (context.rank() == Rank(0)) context.create<Counter>();
  });
  runtime.run([&](Context& context) { context.invoke<&Counter::add>(total, mine); });
  std::int64_t sum = 0;
  runtime.visit<Counter>(
      [&](MobilePtr<Counter> ptr, Counter& counter) { sum += ptr == total ? counter.sum : 0; });
  return sum;
}

TEST_P(RuntimeOnRanks, EndsAtOnceWhenThereIsNothingToDo) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = counters();
    Runtime runtime(transport, registry);
    runtime.run();
    runtime.run([](Context&) {});
  });
}

TEST_P(RuntimeOnRanks, HandlesMessagesFromAllRanks) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = counters();
    Runtime runtime(transport, registry, {.balancer = no_balancing()});
    const std::int64_t sum = sum_over_ranks(runtime, 1 + transport.rank().value);
    EXPECT_EQ(sum, transport.rank() == Rank(0) ? GetParam() * (GetParam() + 1) / 2 : 0);
  });
}

TEST_P(RuntimeOnRanks, DeliversManySmallMessages) {
  const int messages = static_cast<int>(support::repetitions(200'000, 1'000'000)) / kSlowness / GetParam();
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = counters();
    Runtime runtime(transport, registry, {.balancer = no_balancing()});
    runtime.run([&](Context& context) { context.create<Counter>(); });
    runtime.run([&](Context& context) {
      for (int i = 0; i < messages; ++i) {
        const int to = static_cast<int>(mix(static_cast<unsigned>(i)) % static_cast<unsigned>(GetParam()));
        context.invoke<&Counter::add>(MobilePtr<Counter>{{Rank(to), 1}}, i);
      }
    });
    std::int64_t expected = 0;
    std::int64_t calls = 0;
    for (int i = 0; i < messages; ++i) {
      if (static_cast<int>(mix(static_cast<unsigned>(i)) % static_cast<unsigned>(GetParam())) !=
          transport.rank().value) {
        continue;
      }
      expected += std::int64_t{i} * GetParam();
      calls += GetParam();
    }
    runtime.visit<Counter>([&](MobilePtr<Counter>, Counter& counter) {
      EXPECT_EQ(counter.sum, expected);
      EXPECT_EQ(counter.calls, calls);
    });
  });
}

// --- Walkers: messages that hop at random between objects which move all the time. Each object checks that
// the messages of every sender come in the order in which that sent them.

struct Walker {
  std::map<ObjectId, std::uint64_t> last_seen;
  std::map<ObjectId, std::uint64_t> last_sent;
  std::vector<ObjectId> all;
  std::uint64_t checksum = 0;
  std::uint64_t visits = 0;
  std::uint64_t disorder = 0;
  std::vector<double> ballast;  ///< so that packing has something to do

  template <class Archive>
  void serialize(Archive& archive) {
    archive(last_seen, last_sent, all, checksum, visits, disorder, ballast);
  }
  void know(Context&, const std::vector<ObjectId>& ids, std::size_t size) {
    all = ids;
    ballast.assign(size, 1.5);
  }
  void visit(Context& context, ObjectId from, std::uint64_t number, std::uint64_t token, int hops) {
    if (number != ++last_seen[from]) ++disorder;
    ++visits;
    checksum += mix(token + static_cast<std::uint64_t>(hops));
    if (hops == 0) return;
    const ObjectId next = all[mix(token ^ static_cast<std::uint64_t>(hops)) % all.size()];
    context.invoke<&Walker::visit>(MobilePtr<Walker>{next}, context.self(), ++last_sent[next], token,
                                   hops - 1);
  }
};

struct WalkParameters {
  BalancerFactory balancer;
  int threads = 1;
  std::chrono::microseconds delay{0};
};

void walk(Transport& network, const WalkParameters& parameters) {
  const int objects = 16;  // of each rank
  const int tokens = 8;    // of each object
  const int hops = static_cast<int>(support::repetitions(40, 200)) / kSlowness;
  const auto late =
      parameters.delay.count() > 0 ? weft::testing::delayed(network, parameters.delay, 5) : nullptr;
  Transport& transport = late ? *late : network;
  Registry registry;
  registry.type<Walker>("Walker").method<&Walker::know>("know").method<&Walker::visit>("visit");
  registry.type<Counter>("Counter").method<&Counter::add>("add");
  Runtime runtime(transport, registry, {.threads = parameters.threads, .balancer = parameters.balancer});
  std::vector<ObjectId> all;
  for (int r = 0; r < transport.size(); ++r) {
    for (int i = 0; i < objects; ++i) all.push_back({Rank(r), static_cast<std::uint32_t>(i + 1)});
  }
  runtime.run([&](Context& context) {
    for (int i = 0; i < objects; ++i) {
      const auto walker = context.create<Walker>();
      context.invoke<&Walker::know>(walker, all, static_cast<std::size_t>(i) * 300);
    }
    context.create<Counter>();
  });
  runtime.run([&](Context& context) {
    std::map<ObjectId, std::uint64_t> sent;
    for (int i = 0; i < objects * tokens; ++i) {
      const auto token = static_cast<std::uint64_t>(context.rank().value * objects * tokens + i);
      const ObjectId first = all[mix(token) % all.size()];
      context.invoke<&Walker::visit>(MobilePtr<Walker>{first}, context.self(), ++sent[first], token, hops);
    }
  });
  // What arrived, anywhere, against what the tokens must have left behind.
  std::uint64_t checksum = 0;
  std::uint64_t visits = 0;
  runtime.visit<Walker>([&](MobilePtr<Walker>, Walker& walker) {
    EXPECT_EQ(walker.disorder, 0u);
    EXPECT_TRUE(std::all_of(walker.ballast.begin(), walker.ballast.end(), [](double x) { return x == 1.5; }));
    checksum += walker.checksum;
    visits += walker.visits;
  });
  std::uint64_t expected = 0;
  for (int token = 0; token < transport.size() * objects * tokens; ++token) {
    for (int h = 0; h <= hops; ++h) expected += mix(static_cast<std::uint64_t>(token + h));
  }
  const MobilePtr<Counter> total{{Rank(0), static_cast<std::uint32_t>(objects + 1)}};
  runtime.run([&](Context& context) {
    context.invoke<&Counter::add>(
        total, static_cast<std::int64_t>(checksum - (context.rank().value == 0 ? expected : 0)));
  });
  runtime.visit<Counter>([&](MobilePtr<Counter> ptr, Counter& counter) {
    EXPECT_TRUE(ptr != total || counter.sum == 0) << "messages were lost or changed";
  });
}

TEST_P(RuntimeOnRanks, KeepsOrderWhileEveryObjectMovesAtRandom) {
  on_ranks(GetParam(), [](Transport& transport) { walk(transport, {.balancer = rotate()}); });
}

TEST_P(RuntimeOnRanks, KeepsOrderWhileObjectsMoveAndPacketsComeLateAndShuffled) {
  on_ranks(GetParam(), [](Transport& transport) {
    walk(transport, {.balancer = rotate(0.5), .threads = 2, .delay = std::chrono::microseconds(500)});
  });
}

TEST_P(RuntimeOnRanks, KeepsOrderUnderWorkStealing) {
  on_ranks(GetParam(),
           [](Transport& transport) { walk(transport, {.balancer = work_stealing(), .threads = 2}); });
}

TEST_P(RuntimeOnRanks, KeepsOrderUnderDiffusion) {
  on_ranks(GetParam(), [](Transport& transport) { walk(transport, {.balancer = diffusion()}); });
}

// --- Events: in every round each object waits for another set of objects.

struct Node {
  std::vector<ObjectId> all;
  std::uint64_t value = 0;
  std::uint64_t fired = 0;
  std::uint64_t rounds = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(all, value, fired, rounds);
  }

  /// Whether `to` waits for `from` in a round: about a third of all, some rounds nobody.
  static bool depends(ObjectId to, ObjectId from, std::uint64_t round) {
    if (round % 7 == 3) return false;
    const std::hash<ObjectId> hash;
    return mix(hash(to) * 31 + hash(from) * 17 + round) % 3 == 0;
  }
  static std::uint64_t value_of(ObjectId from, std::uint64_t round) {
    return mix(std::hash<ObjectId>{}(from) + round * 1000);
  }

  void begin(Context& context, const std::vector<ObjectId>& ids, std::uint64_t last_round) {
    all = ids;
    rounds = last_round;
    next(context, 0);
  }
  void next(Context& context, std::uint64_t round) {
    if (round == rounds) return;
    std::vector<ObjectId> dependencies;
    for (const ObjectId id : all) {
      if (depends(context.self(), id, round)) dependencies.push_back(id);
      if (depends(id, context.self(), round)) {
        context.signal<&Node::gathered>(MobilePtr<Node>{id}, round, value_of(context.self(), round));
      }
    }
    context.expect<&Node::gathered>(round, dependencies);
  }
  void gathered(Context& context, std::uint64_t round, std::vector<Arrival<std::uint64_t>> arrivals) {
    std::size_t expected = 0;
    for (const ObjectId id : all) {
      if (!depends(context.self(), id, round)) continue;
      if (expected >= arrivals.size() || arrivals[expected].from != id)
        throw std::runtime_error("wrong arrivals");
      if (arrivals[expected].value != value_of(id, round)) throw std::runtime_error("wrong value");
      ++expected;
    }
    if (expected != arrivals.size()) throw std::runtime_error("too many arrivals");
    if (round != fired) throw std::runtime_error("round out of turn");
    ++fired;
    next(context, round + 1);
  }
};

TEST_P(RuntimeOnRanks, FiresEventsOverChangingNeighboursForManyRounds) {
  const std::uint64_t rounds = support::repetitions(150, 1000) / kSlowness;
  const std::uint32_t objects = 4;
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry;
    registry.type<Node>("Node").method<&Node::begin>("begin").event<&Node::gathered>("gathered");
    Runtime runtime(transport, registry, {.threads = 2, .balancer = rotate(0.05)});
    std::vector<ObjectId> all;
    for (int r = 0; r < transport.size(); ++r) {
      for (std::uint32_t i = 1; i <= objects; ++i) all.push_back({Rank(r), i});
    }
    runtime.run([&](Context& context) {
      for (std::uint32_t i = 0; i < objects; ++i) {
        context.invoke<&Node::begin>(context.create<Node>(), all, rounds);
      }
    });
    runtime.visit<Node>([&](MobilePtr<Node>, Node& node) { EXPECT_EQ(node.fired, rounds); });
  });
}

// --- Termination

/// A message that goes from rank to rank while nothing else happens: the run must not end before it.
struct Relay {
  std::int64_t left = -1;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(left);
  }
  void pass(Context& context, std::int64_t hops) {
    left = hops;
    const std::int32_t next = (context.self().home.value + 1) % context.ranks();
    if (hops > 0) context.invoke<&Relay::pass>(MobilePtr<Relay>{{Rank(next), 1}}, hops - 1);
  }
};

TEST_P(RuntimeOnRanks, NeverEndsWhileAMessageFlies) {
  const std::int64_t hops = 300;
  on_ranks(GetParam(), [&](Transport& network) {
    const auto transport = weft::testing::delayed(network, std::chrono::milliseconds(2), 11);
    Registry registry;
    registry.type<Relay>("Relay").method<&Relay::pass>("pass");
    Runtime runtime(*transport, registry, {.balancer = rotate(0.3)});
    runtime.run([&](Context& context) { context.create<Relay>(); });
    runtime.run([&](Context& context) {
      if (context.rank() == Rank(0)) context.invoke<&Relay::pass>(MobilePtr<Relay>{{Rank(0), 1}}, hops);
    });
    const auto last_home = static_cast<std::int32_t>(hops % transport->size());
    runtime.visit<Relay>([&](MobilePtr<Relay> relay, Relay& state) {
      EXPECT_TRUE(relay.id.home != Rank(last_home) || state.left == 0);
    });
  });
}

// --- Handlers

struct Exclusive {
  static inline std::atomic<int> running_somewhere{0};
  static inline std::atomic<int> most_running{0};
  bool inside = false;
  int calls = 0;
  void enter(Context&) {
    EXPECT_FALSE(inside) << "two handlers of one object ran at once";
    inside = true;
    const int running = ++running_somewhere;
    int most = most_running;
    while (most < running && !most_running.compare_exchange_weak(most, running)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    --running_somewhere;
    inside = false;
    ++calls;
  }
  void work_in_parallel(Context& context) {
    std::atomic<long> sum{0};
    tbb::parallel_for(0, 10000, [&](int i) {
      sum += i;
      if (i % 1000 == 0) context.invoke<&Exclusive::enter>(MobilePtr<Exclusive>{context.self()});
    });
    EXPECT_EQ(sum, 49995000);
    EXPECT_EQ(calls, 0);
  }
};

TEST(Runtime, RunsOneHandlerPerObjectAndDifferentObjectsInParallel) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  on_ranks(1, [](Transport& transport) {
    Registry registry;
    registry.type<Exclusive>("Exclusive").method<&Exclusive::enter>("enter");
    Runtime runtime(transport, registry, {.threads = 4});
    runtime.run([](Context& context) {
      for (int i = 0; i < 8; ++i) {
        const auto object = context.create<Exclusive>();
        for (int call = 0; call < 5; ++call) context.invoke<&Exclusive::enter>(object);
      }
    });
    int calls = 0;
    runtime.visit<Exclusive>([&](MobilePtr<Exclusive>, Exclusive& object) { calls += object.calls; });
    EXPECT_EQ(calls, 40);
    EXPECT_GE(Exclusive::most_running, 2);
    EXPECT_LE(Exclusive::most_running, 4);
  });
}

TEST(Runtime, LetsAHandlerWorkInParallelAndSendFromAllItsThreads) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  on_ranks(1, [](Transport& transport) {
    Registry registry;
    registry.type<Exclusive>("Exclusive")
        .method<&Exclusive::enter>("enter")
        .method<&Exclusive::work_in_parallel>("work_in_parallel");
    Runtime runtime(transport, registry, {.threads = 3});
    runtime.run(
        [](Context& context) { context.invoke<&Exclusive::work_in_parallel>(context.create<Exclusive>()); });
    runtime.visit<Exclusive>([&](MobilePtr<Exclusive>, Exclusive& object) { EXPECT_EQ(object.calls, 10); });
  });
}

/// Its loop lasts until two threads are at it.
struct Sociable {
  void work(Context&) {
    std::mutex mutex;
    std::set<std::thread::id> seen;
    const auto company = [&] {
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
      return seen.size() > 1;
    };
    const auto begin = std::chrono::steady_clock::now();
    tbb::parallel_for(0, 64, [&](int) {
      while (!company() && std::chrono::steady_clock::now() - begin < std::chrono::seconds(20))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    EXPECT_GT(seen.size(), 1u);
  }
};

TEST(Runtime, AccountsForThreadsThatHelp) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  on_ranks(1, [](Transport& transport) {
    Registry registry;
    registry.type<Sociable>("Sociable").method<&Sociable::work>("work");
    for (const int threads : {1, 3}) {
      Runtime runtime(transport, registry, {.threads = threads, .trace = {.spans = true}});
      if (threads > 1)
        for (int run = 0; run < 2; ++run)
          runtime.run([](Context& context) { context.invoke<&Sociable::work>(context.create<Sociable>()); });
      const RankSummary summary = runtime.summary();
      const TimeSummary& times = summary.times;
      EXPECT_EQ(times.help > 0, threads > 1);
      EXPECT_LE(times.computed() + times.idle, summary.workers * summary.wall * 1.02 + 0.01);
      const auto lanes = runtime.timeline().value().lanes;
      const bool has_helper = std::ranges::any_of(
          lanes, [](const LaneTimeline& lane) { return lane.name.starts_with("helper"); });
      EXPECT_EQ(has_helper, threads > 1);
    }
  });
}

/// Many short handlers with loops: helpers are often in the way of workers, and do their work.
struct Hasty {
  void work(Context& context, int more) {
    tbb::parallel_for(0, 8, [](int) { std::this_thread::sleep_for(std::chrono::microseconds(200)); });
    if (more > 0) context.invoke<&Hasty::work>(MobilePtr<Hasty>{context.self()}, more - 1);
  }
};

TEST(Runtime, CountsNoTimeAsHelpAndAsAWorkersToo) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  on_ranks(1, [](Transport& transport) {
    Registry registry;
    registry.type<Hasty>("Hasty").method<&Hasty::work>("work");
    Runtime runtime(transport, registry, {.threads = 2});
    for (int run = 0; run < 10; ++run)
      runtime.run([](Context& context) {
        for (int i = 0; i < 3; ++i) context.invoke<&Hasty::work>(context.create<Hasty>(), 30);
      });
    const RankSummary summary = runtime.summary();
    EXPECT_LE(summary.times.computed(), summary.workers * summary.wall * 1.01);
  });
}

/// Nested parallelism that sends to other objects of the rank while these wait for workers of their own.
struct Spreader {
  std::atomic<int> calls{0};
  void spread(Context& context, std::uint32_t objects) {
    tbb::parallel_for(0, 400, [&](int i) {
      context.invoke<&Spreader::count>(
          MobilePtr<Spreader>{{Rank(0), 1 + static_cast<std::uint32_t>(i) % objects}});
    });
  }
  void count(Context&) { ++calls; }
};

TEST(Runtime, SendsFromParallelLoopsWhileOtherWorkersStart) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  const std::uint32_t objects = 6;
  for (const int threads : {1, 2, 3}) {
    for (int repetition = 0; repetition < 20; ++repetition) {
      on_ranks(1, [&](Transport& transport) {
        Registry registry;
        registry.type<Spreader>("Spreader")
            .method<&Spreader::spread>("spread")
            .method<&Spreader::count>("count");
        Runtime runtime(transport, registry, {.threads = threads});
        runtime.run([&](Context& context) {
          for (std::uint32_t i = 0; i < objects; ++i) {
            context.invoke<&Spreader::spread>(context.create<Spreader>(), objects);
          }
        });
        int calls = 0;
        runtime.visit<Spreader>([&](MobilePtr<Spreader>, Spreader& object) { calls += object.calls; });
        EXPECT_EQ(calls, 400 * static_cast<int>(objects));
      });
    }
  }
}

// --- Moving on request, destruction

struct Traveller {
  std::vector<std::int32_t> seen;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(seen);
  }
  void look(Context& context) { seen.push_back(context.rank().value); }
};

TEST_P(RuntimeOnRanks, MovesObjectsOnRequestInTurnWithTheirMessages) {
  on_ranks(GetParam(), [](Transport& transport) {
    Registry registry;
    registry.type<Traveller>("Traveller").method<&Traveller::look>("look");
    Runtime runtime(transport, registry, {.balancer = no_balancing()});
    const int last = transport.size() - 1;
    runtime.run([&](Context& context) {
      if (context.rank() != Rank(0)) return;
      const auto traveller = context.create<Traveller>();
      for (int r = 0; r <= last; ++r) {
        context.migrate(traveller, Rank(r));
        context.invoke<&Traveller::look>(traveller);
      }
    });
    int found = 0;
    runtime.visit<Traveller>([&](MobilePtr<Traveller>, Traveller& traveller) {
      ++found;
      std::vector<std::int32_t> all(static_cast<std::size_t>(transport.size()));
      std::iota(all.begin(), all.end(), 0);
      EXPECT_EQ(traveller.seen, all);
    });
    EXPECT_EQ(found, transport.rank() == Rank(last) ? 1 : 0);
  });
}

TEST_P(RuntimeOnRanks, DestroysObjectsAfterTheirMessages) {
  on_ranks(GetParam(), [](Transport& transport) {
    const Registry registry = counters();
    Runtime runtime(transport, registry);
    runtime.run([](Context& context) {
      for (int i = 0; i < 10; ++i) {
        const auto counter = context.create<Counter>();
        context.invoke<&Counter::add>(counter, 1);
        context.destroy(counter);
      }
    });
    runtime.visit<Counter>([](MobilePtr<Counter>, Counter&) { ADD_FAILURE() << "not destroyed"; });
  });
}

// --- Large and many

struct Store {
  std::uint64_t bytes = 0;
  std::uint64_t sum = 0;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(bytes, sum);
  }
  void put(Context&, std::vector<std::uint32_t> values) {
    bytes += values.size() * sizeof(std::uint32_t);
    sum = std::accumulate(values.begin(), values.end(), sum);
  }
  void put_slowly(Context& context, std::vector<std::uint32_t> values) {
    put(context, std::move(values));
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
};

TEST_P(RuntimeOnRanks, CarriesLargeArgumentsThroughASmallWindow) {
  on_ranks(GetParam(), [](Transport& transport) {
    Registry registry;
    registry.type<Store>("Store").method<&Store::put>("put");
    Runtime runtime(
        transport, registry,
        {.balancer = rotate(0.2), .exchange = {.window_bytes = 64 << 10, .backlog_bytes = 1 << 20}});
    runtime.run([](Context& context) { context.create<Store>(); });
    std::uint64_t expected = 0;
    for (std::uint32_t size = 1; size < 2'000'000; size = size * 3 + 1)
      expected += std::uint64_t{size} * size;
    runtime.run([](Context& context) {
      for (std::uint32_t size = 1; size < 2'000'000; size = size * 3 + 1) {
        for (int r = 0; r < context.ranks(); ++r) {
          context.invoke<&Store::put>(MobilePtr<Store>{{Rank(r), 1}}, std::vector<std::uint32_t>(size, size));
        }
      }
    });
    runtime.visit<Store>([&](MobilePtr<Store>, Store& store) {
      EXPECT_EQ(store.sum, expected * static_cast<std::uint64_t>(transport.size()));
    });
  });
}

TEST_P(RuntimeOnRanks, HoldsUpFastSendersForASlowReceiver) {
  if (GetParam() == 1) GTEST_SKIP() << "for several ranks";
  on_ranks(GetParam(), [](Transport& transport) {
    Registry registry;
    registry.type<Store>("Store").method<&Store::put_slowly>("put_slowly");
    Runtime runtime(
        transport, registry,
        {.balancer = no_balancing(), .exchange = {.window_bytes = 1 << 20, .backlog_bytes = 1 << 20}});
    runtime.run([](Context& context) {
      if (context.rank() == Rank(0)) context.create<Store>();
    });
    // 100 MB in all; the sender may be ahead of the receiver by a window and a backlog.
    const int messages = 1000 / kSlowness;
    std::chrono::duration<double> sending{};
    runtime.run([&](Context& context) {
      if (context.rank() != Rank(1)) return;
      const auto begin = std::chrono::steady_clock::now();
      for (int i = 0; i < messages; ++i) {
        context.invoke<&Store::put_slowly>(MobilePtr<Store>{{Rank(0), 1}},
                                           std::vector<std::uint32_t>(25'000, 1));
      }
      sending = std::chrono::steady_clock::now() - begin;
    });
    runtime.visit<Store>([&](MobilePtr<Store>, Store& store) {
      EXPECT_EQ(store.sum, 25'000u * static_cast<unsigned>(messages));
    });
    // All but 2 MB, so 20 messages, must have been handled when the last was sent.
    if (transport.rank() == Rank(1)) {
      EXPECT_GT(sending.count(), (messages - 30) * 200e-6);
    }
  });
}

// --- Balancing

struct Worker {
  static constexpr int kMilliseconds = 10;  // worth moving also where packing is slow, as under sanitizers
  int calls = 0;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(calls);
  }
  void work(Context&) {
    ++calls;
    std::this_thread::sleep_for(std::chrono::milliseconds(kMilliseconds));
  }
};

/// The first of a process to move takes long, as one may that needs memory from the system.
struct HeldUpWorker : Worker {
  static inline std::atomic<bool> held_up{false};
  template <class Archive>
  void serialize(Archive& archive) {
    if (!held_up.exchange(true)) {
      const TimePoint begin = processor_time();
      while (processor_time() - begin < 20'000'000) continue;
    }
    archive(calls);
  }
  void work(Context& context) { Worker::work(context); }
};

template <class Object>
void expect_spread(int ranks, const BalancerFactory& balancer) {
  on_ranks(ranks, [&](Transport& transport) {
    Registry registry;
    registry.type<Object>("Worker").template method<&Object::work>("work");
    Runtime runtime(transport, registry, {.balancer = balancer});
    const int objects = 40;
    runtime.run([&](Context& context) {
      if (context.rank() != Rank(0)) return;
      for (int i = 0; i < objects; ++i) {
        const auto worker = context.create<Object>();
        for (int call = 0; call < 3; ++call)
          context.invoke_expecting<&Object::work>(Seconds{1e-3 * Object::kMilliseconds}, worker);
      }
    });
    runtime.visit<Object>([](MobilePtr<Object>, Object& worker) { EXPECT_EQ(worker.calls, 3); });
    std::uint64_t calls = 0;
    for (const MethodSummary& method : runtime.summary().methods) calls += method.count;
    // Everybody sleeps, so work can spread evenly on any machine; much less than its share would mean that
    // none moved.
    EXPECT_GE(calls, static_cast<std::uint64_t>(3 * objects / transport.size() / 4));
  });
}

/// A policy whose messages were under way when a run ended must not be lame in the next.
TEST_P(RuntimeOnRanks, StealingSpreadsWorkInTheTwentiethRunToo) {
  on_ranks(GetParam(), [](Transport& transport) {
    Registry registry;
    registry.type<Worker>("Worker").method<&Worker::work>("work");
    Runtime runtime(transport, registry);
    const int objects = 40;
    for (int run = 0; run < 20; ++run) runtime.run([](Context&) {});
    runtime.run([&](Context& context) {
      if (context.rank() != Rank(0)) return;
      for (int i = 0; i < objects; ++i)
        context.invoke_expecting<&Worker::work>(Seconds{1e-3 * Worker::kMilliseconds},
                                                context.create<Worker>());
    });
    std::uint64_t calls = 0;
    for (const MethodSummary& method : runtime.summary().methods) calls += method.count;
    EXPECT_GE(calls, static_cast<std::uint64_t>(objects / transport.size() / 4));
  });
}

TEST_P(RuntimeOnRanks, StealingSpreadsWorkThatStartsOnOneRank) {
  expect_spread<Worker>(GetParam(), work_stealing());
}
TEST_P(RuntimeOnRanks, DiffusionSpreadsWorkThatStartsOnOneRank) {
  expect_spread<Worker>(GetParam(), diffusion());
}

/// What moving takes is judged by a few moves: by the first alone none would be worth its way any more.
TEST_P(RuntimeOnRanks, StealingSpreadsWorkThoughTheFirstMoveTookLong) {
  HeldUpWorker::held_up = false;
  expect_spread<HeldUpWorker>(GetParam(), work_stealing());
}
TEST_P(RuntimeOnRanks, DiffusionSpreadsWorkThoughTheFirstMoveTookLong) {
  HeldUpWorker::held_up = false;
  expect_spread<HeldUpWorker>(GetParam(), diffusion());
}

/// Remembers what its rank had to do when it was last asked.
class LoadKeeper final : public Balancer {
 public:
  explicit LoadKeeper(Load& load) : load_(load) {}
  void step(BalanceActions& actions, TimePoint) override { load_ = actions.load(); }
  void told(Rank, const BalanceMessage&, BalanceActions&) override {}

 private:
  Load& load_;
};

/// (.1 + .2 + .3) - .1 - .2 - .3 is no zero in doubles: who has nothing would be asked for work.
TEST(Runtime, WithoutMessagesThereIsNoLoad) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  on_ranks(1, [](Transport& transport) {
    const Registry registry = counters();
    Load last;
    Runtime runtime(transport, registry,
                    {.balancer = [&](Rank, int) { return std::make_unique<LoadKeeper>(last); }});
    runtime.run([](Context& context) {  // keeps the only worker until all are queued
      const auto counter = context.create<Counter>();
      for (const double seconds : {0.1, 0.2, 0.3})
        context.invoke_expecting<&Counter::add>(Seconds{seconds}, counter, 1);
    });
    EXPECT_EQ(last.handled, 3u);
    EXPECT_EQ(last.queued_seconds, 0);
  });
}

// --- Reports

TEST_P(RuntimeOnRanks, SummariesAgreeAndNoCallIsCollective) {
  on_ranks(GetParam(), [](Transport& transport) {
    const Registry registry = counters();
    Runtime runtime(transport, registry, {.balancer = rotate(0.5), .trace = {.spans = true}});
    runtime.run([](Context& context) { context.create<Counter>(); });
    runtime.run([](Context& context) {
      for (int i = 0; i < 100; ++i) {
        context.invoke<&Counter::add>(MobilePtr<Counter>{{Rank(i % context.ranks()), 1}}, 1);
      }
    });
    std::vector<RankSummary> ranks = runtime.gather_summaries();
    const std::vector<RankTimeline> timelines = runtime.gather_timelines();
    if (transport.rank() != Rank(0)) {
      EXPECT_TRUE(ranks.empty());
      return;
    }
    ASSERT_EQ(ranks.size(), static_cast<std::size_t>(transport.size()));
    ASSERT_EQ(timelines.size(), ranks.size());
    const RunSummary run = merge(std::move(ranks));
    EXPECT_TRUE(run.consistent.messages && run.consistent.bytes && run.consistent.pairs);
    EXPECT_EQ(run.collective_calls, 0);
    EXPECT_EQ(run.network_calls.empty(), !weft::testing::is_distributed());
    ASSERT_FALSE(run.methods.empty());
    const auto add = std::find_if(run.methods.begin(), run.methods.end(),
                                  [](const MethodSummary& method) { return method.name == "Counter::add"; });
    ASSERT_NE(add, run.methods.end());
    EXPECT_EQ(add->count, 100u * static_cast<unsigned>(transport.size()));
  });
}

}  // namespace
}  // namespace weft::engine::runtime_test

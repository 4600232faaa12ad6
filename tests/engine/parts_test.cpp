// The engine's parts, each alone: directory, events, termination, registry, scheduler, exchange.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "engine/network/exchange.h"
#include "engine/network/load_table.h"
#include "engine/network/loopback_transport.h"
#include "engine/objects/directory.h"
#include "engine/objects/event.h"
#include "engine/objects/registry.h"
#include "engine/run/awake_clock.h"
#include "engine/schedule/context.h"
#include "engine/schedule/scheduler.h"
#include "engine/schedule/termination.h"
#include "tests/support/failing_new.h"

namespace weft::engine::parts_test {
namespace {

using ::testing::ElementsAre;

constexpr ObjectId kA{Rank(0), 1};
constexpr ObjectId kB{Rank(1), 4};
constexpr ObjectId kC{Rank(2), 9};

// --- Directory

TEST(Directory, GuessesHomeUntilItLearnsMore) {
  Directory directory{Rank(0)};
  EXPECT_EQ(directory.best_guess(kB).rank, Rank(1));
  directory.learn(kB, {Rank(3), 2});
  EXPECT_EQ(directory.best_guess(kB).rank, Rank(3));
  EXPECT_EQ(directory.best_guess(kB).age, 2u);
}

TEST(Directory, IgnoresOlderNews) {
  Directory directory{Rank(0)};
  directory.learn(kB, {Rank(3), 5});
  directory.learn(kB, {Rank(2), 4});
  EXPECT_EQ(directory.best_guess(kB).rank, Rank(3));
}

TEST(Directory, SendsOnOnlyToNewerLocations) {
  Directory directory{Rank(0)};
  EXPECT_FALSE(directory.newer(kB, 0));
  directory.learn(kB, {Rank(3), 5});
  EXPECT_FALSE(directory.newer(kB, 5)) << "the object of age 5 is still on its way";
  ASSERT_TRUE(directory.newer(kB, 4));
  EXPECT_EQ(directory.newer(kB, 4)->rank, Rank(3));
}

TEST(Directory, KnowsWhatWasDestroyedAndWhatIsToCome) {
  Directory directory{Rank(0)};
  const ObjectId later{Rank(0), 8};
  EXPECT_TRUE(directory.is_gone(kA, 3));
  EXPECT_TRUE(directory.is_to_come(later, 3));
  EXPECT_FALSE(directory.is_gone(later, 3));
  EXPECT_FALSE(directory.is_gone(kB, 3)) << "another rank's object";
  directory.destroyed(kB);
  EXPECT_TRUE(directory.is_gone(kB, 3));
  directory.learn(kB, {Rank(2), 9});
  EXPECT_TRUE(directory.is_gone(kB, 3)) << "late news of its life";
}

/// Rule 2 of directory.h on random journeys with messages sent from anywhere: each arrives, in at most as
/// many hops as the object moved.
TEST(Directory, EveryMessageArrivesInAtMostAsManyHopsAsMoves) {
  std::mt19937 random(3);
  const int ranks = 6;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Directory> directories;
    for (int r = 0; r < ranks; ++r) directories.emplace_back(Rank(r));
    Rank at(0);
    std::uint32_t age = 0;
    for (int move = 0; move < 12; ++move) {
      const Rank to(static_cast<int>(random() % ranks));
      if (to == at) continue;
      directories[at.index()].learn(kA, {to, ++age});
      directories[to.index()].arrived(kA);
      at = to;
      if (random() % 3 == 0) directories[random() % ranks].learn(kA, {at, age});
    }
    for (int from = 0; from < ranks; ++from) {
      if (Rank(from) == at) continue;
      Location next = directories[static_cast<std::size_t>(from)].best_guess(kA);
      std::uint32_t hops = 0;
      while (next.rank != at) {
        const auto newer = directories[next.rank.index()].newer(kA, next.age);
        ASSERT_TRUE(newer) << "lost on rank " << next.rank.value;
        ASSERT_GT(newer->age, next.age);
        next = *newer;
        ASSERT_LE(++hops, age);
      }
    }
  }
}

// --- Events

Payload bytes(std::initializer_list<int> values) {
  Payload payload;
  for (const int value : values) payload.bytes.push_back(static_cast<std::byte>(value));
  return payload;
}

TEST(EventTable, FiresWhenAllHaveArrivedWhateverTheOrder) {
  EventTable events;
  EXPECT_FALSE(events.arrive({1, 0}, kC, bytes({3})));
  EXPECT_FALSE(events.declare({1, 0}, {kA, kB, kC}, 0.5));
  EXPECT_FALSE(events.arrive({1, 0}, kB, bytes({2})));
  const auto fired = events.arrive({1, 0}, kA, bytes({1}));
  ASSERT_TRUE(fired);
  EXPECT_EQ(fired->expected, 0.5);
  ASSERT_EQ(fired->arrivals.size(), 3u);
  EXPECT_EQ(fired->arrivals[0].first, kA);
  EXPECT_EQ(fired->arrivals[2].second.bytes, bytes({3}).bytes);
  EXPECT_TRUE(events.empty());
}

TEST(EventTable, WithoutDependenciesFiresAtOnce) {
  EventTable events;
  EXPECT_TRUE(events.declare({1, 0}, {}, 0));
}

TEST(EventTable, KeepsRoundsAndEventsApart) {
  EventTable events;
  EXPECT_FALSE(events.declare({1, 0}, {kA}, 0));
  EXPECT_FALSE(events.declare({1, 1}, {kA}, 0));
  EXPECT_FALSE(events.declare({2, 0}, {kA}, 0));
  const auto fired = events.arrive({1, 1}, kA, {});
  ASSERT_TRUE(fired);
  EXPECT_EQ(fired->key.round, 1u);
  EXPECT_EQ(events.waits().size(), 2u);
}

TEST(EventTable, RefusesMisuse) {
  EventTable events;
  events.declare({1, 0}, {kA, kB}, 0);
  EXPECT_THROW(events.declare({1, 0}, {kA}, 0), std::logic_error);
  EXPECT_THROW(events.arrive({1, 0}, kC, {}), std::logic_error);
  events.arrive({1, 0}, kA, {});
  EXPECT_THROW(events.arrive({1, 0}, kA, {}), std::logic_error);
  events.arrive({1, 5}, kC, {});
  EXPECT_THROW(events.declare({1, 5}, {kA}, 0), std::logic_error);
  EXPECT_THROW(events.declare({1, 6}, {kA, kA}, 0), std::logic_error);
}

TEST(EventTable, SaysWhoIsMissing) {
  EventTable events;
  events.declare({1, 4}, {kA, kB}, 0);
  events.arrive({1, 4}, kB, {});
  const std::vector<EventWait> waits = events.waits();
  ASSERT_EQ(waits.size(), 1u);
  EXPECT_THAT(waits[0].missing, ElementsAre(kA));
  EXPECT_THAT(waits[0].arrived, ElementsAre(kB));
}

TEST(EventTable, TravelsHalfFull) {
  EventTable events;
  events.declare({1, 4}, {kA, kB}, 0.25);
  events.arrive({1, 4}, kB, bytes({7}));
  Packer packer(true);
  packer(events);
  EventTable there;
  Unpacker unpacker(packer.take());
  unpacker(there);
  unpacker.finish();
  const auto fired = there.arrive({1, 4}, kA, {});
  ASSERT_TRUE(fired);
  EXPECT_EQ(fired->arrivals[1].second.bytes, bytes({7}).bytes);
}

// --- Termination: ranks simulated with random activity and messages that take random time and overtake each
// other.

class Simulation {
 public:
  Simulation(int ranks, unsigned seed)
      : random_(seed), ranks_(ranks), sent_(ranks), received_(ranks), active_(ranks) {
    for (int r = 0; r < ranks; ++r) {
      detectors_.emplace_back(Rank(r), ranks, [this](Rank to, const WaveMessage& message) {
        waves_.push_back({to, message});
      });
      active_[static_cast<std::size_t>(r)] = random_() % 2 == 0;
    }
  }

  /// Some random thing happens. `budget`: application messages that may still be sent.
  void step(int& budget) {
    ++time_;
    const auto r = static_cast<std::size_t>(random_()) % static_cast<std::size_t>(ranks_);
    switch (random_() % 4) {
      case 0:
        if (active_[r] && budget > 0)
          --budget, ++sent_[r], flying_.push_back(random_() % static_cast<unsigned>(ranks_));
        break;
      case 1:
        if (active_[r] && random_() % 3 == 0) active_[r] = false;
        break;
      case 2:
        if (!flying_.empty()) {
          std::swap(flying_[random_() % flying_.size()], flying_.back());
          const std::size_t to = flying_.back();
          flying_.pop_back();
          ++received_[to];
          active_[to] = true;
        }
        break;
      default:
        if (!waves_.empty()) {
          std::swap(waves_[random_() % waves_.size()], waves_.back());
          const auto [to, message] = waves_.back();
          waves_.pop_back();
          detectors_[to.index()].receive(Rank(), message);
        }
    }
    std::optional<WaveCount> count;
    if (!active_[r]) count = WaveCount{sent_[r], received_[r], 0};
    detectors_[r].step(count, time_ * 10'000);
  }

  bool quiet() const {
    return flying_.empty() && std::none_of(active_.begin(), active_.end(), [](char a) { return a != 0; });
  }
  bool anybody_ended() const {
    return std::any_of(detectors_.begin(), detectors_.end(),
                       [](const auto& d) { return d.ended().has_value(); });
  }
  bool all_ended() const {
    return std::all_of(detectors_.begin(), detectors_.end(),
                       [](const auto& d) { return d.ended().has_value(); });
  }

 private:
  std::mt19937 random_;
  int ranks_;
  std::vector<std::uint64_t> sent_, received_;
  std::vector<char> active_;
  std::vector<std::size_t> flying_;
  std::vector<std::pair<Rank, WaveMessage>> waves_;
  std::vector<Termination> detectors_;
  TimePoint time_ = 0;
};

TEST(Termination, IsNeverTooEarlyAndAlwaysComes) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    Simulation simulation(1 + static_cast<int>(seed % 9), seed);
    int budget = 60;
    int steps_after_end = 0;
    while (!simulation.all_ended()) {
      simulation.step(budget);
      if (!simulation.quiet()) {
        ASSERT_FALSE(simulation.anybody_ended()) << "seed " << seed;
      } else {
        ASSERT_LT(++steps_after_end, 100'000) << "seed " << seed;
      }
    }
  }
}

constexpr TimePoint kSecond = 1'000'000'000;

TEST(Termination, WorkThatLastsIsNoLostMessage) {
  Termination alone(Rank(0), 1, [](Rank, const WaveMessage&) {});
  constexpr TimePoint kLong = 1000 * kSecond;
  TimePoint time = kLong;
  for (; !alone.ended(); ++time) alone.step(WaveCount{7, 7}, time);
  EXPECT_EQ(alone.futile_for(), 0);
}

TEST(Termination, TellsForHowLongMessagesHaveBeenMissing) {
  Termination alone(Rank(0), 1, [](Rank, const WaveMessage&) {});
  alone.step(WaveCount{7, 6}, 1000 * kSecond);
  EXPECT_EQ(alone.futile_for(), 0);
  for (int i = 1; i <= 6; ++i) alone.step(WaveCount{7, 6}, 1000 * kSecond + i * kSecond / 2);
  EXPECT_EQ(alone.futile_for(), 3 * kSecond);
  alone.step(WaveCount{7, 6}, 5000 * kSecond);
  EXPECT_EQ(alone.futile_for(), 4 * kSecond) << "suspended, and no message lost";
  alone.step(WaveCount{8, 7}, 5001 * kSecond);
  EXPECT_EQ(alone.futile_for(), 0);
  EXPECT_FALSE(alone.ended());
}

// --- Registry

struct Plain {
  void act(Context&) {}
};
struct Mobile {
  template <class Archive>
  void serialize(Archive&) {}
  void act(Context&) {}
};

TEST(Registry, KnowsWhatCanMove) {
  Registry registry;
  registry.type<Plain>("Plain").method<&Plain::act>("act");
  registry.type<Mobile>("Mobile").method<&Mobile::act>("act");
  EXPECT_FALSE(registry.type<Plain>().movable);
  EXPECT_TRUE(registry.type<Mobile>().movable);
  EXPECT_EQ(registry.method<&Mobile::act>().name, "Mobile::act");
  EXPECT_NE(registry.method<&Mobile::act>().id, registry.method<&Plain::act>().id);
}

TEST(Registry, RefusesNamesUsedTwiceAndWhatWasNotRegistered) {
  Registry registry;
  registry.type<Plain>("Plain");
  EXPECT_THROW(registry.type<Mobile>("Plain"), std::logic_error);
  EXPECT_THROW(registry.method<&Plain::act>(), std::logic_error);
  EXPECT_THROW(Registry().type<Plain>(), std::logic_error);
  EXPECT_EQ(registry.find_method(12345), nullptr);
}

TEST(Registry, FingerprintsTellProgramsApartAndNotTheOrderOfRegistration) {
  Registry one, other_order, immovable, fewer;
  one.type<Plain>("Plain").method<&Plain::act>("act");
  one.type<Mobile>("Mobile");
  other_order.type<Mobile>("Mobile");
  other_order.type<Plain>("Plain").method<&Plain::act>("act");
  immovable.type<Mobile>("Plain").method<&Mobile::act>("act");
  immovable.type<Plain>("Mobile");
  fewer.type<Plain>("Plain");
  fewer.type<Mobile>("Mobile");
  EXPECT_EQ(one.fingerprint(), other_order.fingerprint());
  EXPECT_NE(one.fingerprint(), immovable.fingerprint());
  EXPECT_NE(one.fingerprint(), fewer.fingerprint());
}

// --- Scheduler

Registry mobiles() {
  Registry registry;
  registry.type<Mobile>("Mobile").method<&Mobile::act>("act");
  return registry;
}

/// The first message of `sender` to an object.
Task message_of(ObjectId sender, const Registry& registry) {
  Task task;
  task.envelope.target = kA;
  task.envelope.sender = sender;
  task.envelope.id = 7;
  task.envelope.method = registry.method<&Mobile::act>().id;
  return task;
}

/// The copy of an object for which a message waits.
Payload copy_with_mail(const Registry& registry) {
  PackedCell cell;
  cell.id = kA;
  cell.type = registry.type<Mobile>().id;
  cell.mailbox.push_back(message_of(kB, registry));
  return packed(std::move(cell));
}

TEST(Scheduler, AnObjectThatFoundNoMemoryWaitsForNoWorker) {
  if (!weft::testing::kNewCanFail) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  const Registry registry = mobiles();
  bool failed = true;
  for (int number = 0; failed; ++number) {
    LoopbackNetwork network(1);
    Exchange exchange(network.transport(Rank(0)), {});
    Trace trace(Rank(0), 1, 1);
    Scheduler scheduler({.rank = Rank(0)}, registry, exchange, trace, [] {});
    Payload copy = copy_with_mail(registry);
    {
      const weft::testing::FailingNew memory(number);
      try {
        scheduler.restore_object(std::move(copy));
      } catch (const std::bad_alloc&) {
      }
      failed = memory.has_failed();
    }
    const bool is_there = scheduler.state().size() > 1;  // a line for the rank, one for each object
    EXPECT_TRUE(is_there || failed);
    EXPECT_TRUE(is_there || scheduler.passive_count()) << "allocation " << number;
  }
}

/// They would be the arrows' heads of messages of this run.
TEST(Scheduler, RestoredMessagesHaveNoNumberOfTheRunThatTheyComeFrom) {
  const Registry registry = mobiles();
  LoopbackNetwork network(1);
  Exchange exchange(network.transport(Rank(0)), {});
  Trace trace(Rank(0), 1, 1, {.spans = true});
  Scheduler scheduler({.rank = Rank(0)}, registry, exchange, trace, [] {});
  scheduler.restore_object(copy_with_mail(registry));
  scheduler.restore_message(packed(message_of(kC, registry)));
  scheduler.start({});
  while (!scheduler.passive_count()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_FALSE(scheduler.failure());
  EXPECT_EQ(trace.worker_lane(0).time(Activity::compute).count, 2u);
  for (const Span& span : trace.worker_lane(0).spans().copy()) EXPECT_EQ(span.cause, 0u);
}

// --- The clock of limits on waiting

TEST(AwakeClock, CountsLittleOfATimeInWhichNobodyLooked) {
  AwakeClock clock;
  const TimePoint begin = clock.tick(1000 * kSecond);
  for (int i = 1; i <= 10; ++i) clock.tick(1000 * kSecond + i * kSecond / 4);
  EXPECT_EQ(clock.time() - begin, 10 * kSecond / 4);
  EXPECT_EQ(clock.tick(5000 * kSecond) - begin, 10 * kSecond / 4 + AwakeClock::kLongestGap);
}

// --- Exchange

TEST(LoadTable, KnowsTheMostLoadedOfThoseThatWereHeard) {
  constexpr int kRanks = 100;
  LoadTable table(kRanks);
  EXPECT_EQ(table.of(Rank(3)), -1);
  EXPECT_FALSE(table.most_loaded().valid());
  std::vector<double> loads(kRanks, -1);
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const std::size_t r = random() % kRanks;
    loads[r] = random() % 4 == 0 ? 0 : static_cast<double>(random() % 8);  // equal ones are frequent
    if (i % 1000 > 900) loads[r] = 0;
    table.set(Rank(static_cast<int>(r)), loads[r]);
    EXPECT_EQ(table.of(Rank(static_cast<int>(r))), loads[r]);
    const auto most = std::max_element(loads.begin(), loads.end());
    EXPECT_EQ(table.most_loaded(), *most > 0 ? Rank(static_cast<int>(most - loads.begin())) : Rank());
  }
  for (int r = 0; r < kRanks; ++r) table.set(Rank(r), 0);
  EXPECT_FALSE(table.most_loaded().valid());
}

TEST(Exchange, RefusesARankThatDoesNotExist) {
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {});
  EXPECT_THROW(here.post(Rank(2), FrameKind::task, {}), std::out_of_range);
  EXPECT_THROW(here.post(Rank(), FrameKind::task, {}), std::out_of_range);
}

TEST(Exchange, AFrameThatThrowsDoesNotTakeThoseBehindItAlong) {
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {}), there(network.transport(Rank(1)), {});
  here.begin_phase();
  there.begin_phase();
  for (int i = 0; i < 3; ++i) here.post(Rank(1), FrameKind::task, bytes({i}));
  here.progress([](Rank, FrameKind, Payload, std::size_t) {});
  EXPECT_EQ(here.packets_sent(), 1u);
  int arrived = 0;
  EXPECT_THROW(there.progress([&](Rank, FrameKind, Payload, std::size_t) {
    if (++arrived == 1) throw std::runtime_error("unreadable");
  }),
               std::runtime_error);
  EXPECT_EQ(arrived, 3);
}

TEST(Exchange, HearsOfAnotherProgramOnlyHowTheRunEnds) {
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {}, 1), there(network.transport(Rank(1)), {}, 2);
  here.begin_phase();
  there.begin_phase();
  here.post(Rank(1), FrameKind::task, {});
  here.post(Rank(1), FrameKind::stop, {});
  here.progress([](Rank, FrameKind, Payload, std::size_t) {});
  std::vector<FrameKind> heard;
  EXPECT_THROW(there.progress([&](Rank, FrameKind kind, Payload, std::size_t) { heard.push_back(kind); }),
               std::runtime_error);
  EXPECT_THAT(heard, ElementsAre(FrameKind::stop));
}

TEST(Exchange, SendsManySmallFramesInFewPackets) {
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {});
  Exchange there(network.transport(Rank(1)), {});
  here.begin_phase();
  there.begin_phase();
  const int frames = 10'000;
  for (int i = 0; i < frames; ++i) here.post(Rank(1), FrameKind::task, bytes({i % 256}));
  int arrived = 0;
  const auto receive = [&](Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes) {
    EXPECT_EQ(from, Rank(0));
    EXPECT_EQ(kind, FrameKind::task);
    EXPECT_EQ(payload.bytes, bytes({arrived % 256}).bytes);
    there.consumed(from, wire_bytes);
    ++arrived;
  };
  while (arrived < frames) {
    here.progress([](Rank, FrameKind, Payload, std::size_t) {});
    there.progress(receive);
  }
  EXPECT_LE(here.packets_sent(), 10u);
  EXPECT_TRUE(here.idle());
}

TEST(Exchange, StopsAtTheWindowUntilTheReceiverHasConsumed) {
  const std::size_t window = 100'000;
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {.window_bytes = window, .backlog_bytes = 1 << 30});
  Exchange there(network.transport(Rank(1)), {.window_bytes = window, .backlog_bytes = 1 << 30});
  here.begin_phase();
  there.begin_phase();
  Payload payload;
  payload.bytes.resize(1000);
  for (int i = 0; i < 1000; ++i)
    here.post(Rank(1), FrameKind::task, payload.bytes.empty() ? Payload{} : Payload{payload.bytes, {}});
  std::vector<std::size_t> unconsumed;
  int arrived = 0;
  const auto turn = [&] {
    here.progress([](Rank, FrameKind, Payload, std::size_t) {});
    there.progress([&](Rank, FrameKind, Payload, std::size_t wire_bytes) {
      unconsumed.push_back(wire_bytes);
      ++arrived;
    });
  };
  for (int i = 0; i < 100; ++i) turn();
  EXPECT_GT(arrived, 90);
  EXPECT_LE(arrived, 100);
  EXPECT_FALSE(here.idle());
  // Frames of the engine itself pass.
  here.post(Rank(1), FrameKind::heartbeat, {});
  const int before = arrived;
  turn();
  EXPECT_EQ(arrived, before + 1);
  unconsumed.pop_back();
  while (arrived < 1001) {
    for (const std::size_t wire_bytes : std::exchange(unconsumed, {})) there.consumed(Rank(0), wire_bytes);
    turn();
  }
  EXPECT_TRUE(here.idle());
}

TEST(Exchange, ManyRanksTogetherSendNoMoreThanTheInboxHolds) {
  constexpr int kRanks = 9, kMessages = 200;
  constexpr std::size_t kBytes = 5'000, kInbox = 400'000;  // all that is posted: 8 MB
  LoopbackNetwork network(kRanks);
  const ExchangeOptions options{.window_bytes = 1 << 20, .inbox_bytes = kInbox, .backlog_bytes = 1 << 30};
  std::vector<std::unique_ptr<Exchange>> exchanges;
  for (int r = 0; r < kRanks; ++r) {
    exchanges.push_back(std::make_unique<Exchange>(network.transport(Rank(r)), options));
    exchanges.back()->begin_phase();
  }
  for (int r = 1; r < kRanks; ++r)
    for (int i = 0; i < kMessages; ++i) {
      Payload payload;
      payload.bytes.resize(kBytes);
      exchanges[static_cast<std::size_t>(r)]->post(Rank(0), FrameKind::task, std::move(payload));
    }
  std::vector<std::pair<Rank, std::size_t>> unconsumed;
  std::size_t most = 0;
  int arrived = 0;
  while (arrived < (kRanks - 1) * kMessages) {
    for (int turn = 0; turn < 20; ++turn)
      for (int r = kRanks - 1; r >= 0; --r)
        exchanges[static_cast<std::size_t>(r)]->progress(
            [&](Rank from, FrameKind, Payload, std::size_t wire_bytes) {
              unconsumed.emplace_back(from, wire_bytes);
              ++arrived;
            });
    most = std::max<std::size_t>(most, exchanges[0]->traffic().unhandled);
    ASSERT_FALSE(unconsumed.empty()) << "nothing comes any more";
    for (const auto& [from, wire_bytes] : std::exchange(unconsumed, {}))
      exchanges[0]->consumed(from, wire_bytes);
  }
  EXPECT_LE(most, kInbox);
  EXPECT_GT(most, kInbox / 2) << "the windows are used";
}

TEST(Exchange, AMessageLargerThanTheWindowGoesThoughLittleIsStillUncredited) {
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {.window_bytes = 10'000, .backlog_bytes = 1 << 30});
  Exchange there(network.transport(Rank(1)), {.window_bytes = 10'000, .backlog_bytes = 1 << 30});
  here.begin_phase();
  there.begin_phase();
  here.post(Rank(1), FrameKind::task, bytes({1}));
  Payload large;
  large.segments.push_back(Blob::allocate(1 << 20));
  here.post(Rank(1), FrameKind::task, std::move(large));
  int arrived = 0;
  for (int i = 0; i < 10; ++i) {
    here.progress([](Rank, FrameKind, Payload, std::size_t) {});
    there.progress([&](Rank from, FrameKind, Payload, std::size_t wire_bytes) {
      there.consumed(from, wire_bytes);
      ++arrived;
    });
  }
  EXPECT_EQ(arrived, 2);
}

TEST(Exchange, KeepsFramesOfALaterPhaseForTheOneWhoBeginsIt) {
  LoopbackNetwork network(2);
  const auto use = [&](int rank, int phases) {
    Exchange exchange(network.transport(Rank(rank)), {});
    int arrived = 0;
    for (int phase = 0; phase < phases; ++phase) {
      exchange.begin_phase();
      if (rank == 0) exchange.post(Rank(1), FrameKind::task, {});
      exchange.progress([&](Rank, FrameKind, Payload, std::size_t) { ++arrived; });
    }
    return arrived;
  };
  use(0, 3);
  EXPECT_EQ(use(1, 2), 2);
  // The next user's phases are its own, however many the one before went through on this rank.
  use(0, 2);
  EXPECT_EQ(use(1, 1), 1);
}

TEST(Exchange, AKeptPacketThatThrowsDoesNotTakeThoseBehindItAlong) {
  LoopbackNetwork network(2);
  Exchange here(network.transport(Rank(0)), {}), there(network.transport(Rank(1)), {});
  const auto nothing = [](Rank, FrameKind, Payload, std::size_t) {};
  here.begin_phase();
  there.begin_phase();
  here.begin_phase();
  for (int packet = 0; packet < 3; ++packet) {
    here.post(Rank(1), FrameKind::task, {});
    here.progress(nothing);
  }
  there.progress(nothing);
  there.begin_phase();
  int arrived = 0;
  const auto throw_at_first = [&](Rank, FrameKind, Payload, std::size_t) {
    if (++arrived == 1) throw std::runtime_error("unreadable");
  };
  EXPECT_THROW(there.progress(throw_at_first), std::runtime_error);
  there.progress(throw_at_first);
  EXPECT_EQ(arrived, 3);
}

}  // namespace
}  // namespace weft::engine::parts_test

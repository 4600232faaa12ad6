// Looking on while a run lasts: bulletins on their way to rank 0, and the state that is shown on request.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <set>
#include <thread>
#include <vector>

#include "engine/base/virtual_time.h"
#include "engine/run/runtime.h"
#include "engine/simulate/simulation.h"
#include "tests/support/ranks.h"

namespace weft::engine::looking_on_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using weft::testing::delayed;
using weft::testing::on_ranks;

class LookingOn : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, LookingOn, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

struct Sleeper {
  void sleep(Context&, int milliseconds) {
    if (VirtualTime* simulated = VirtualTime::of_thread())
      return simulated->spend(std::chrono::nanoseconds(std::chrono::milliseconds(milliseconds)).count());
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  }
};

Registry sleepers() {
  Registry registry;
  registry.type<Sleeper>("Sleeper").method<&Sleeper::sleep>("sleep");
  return registry;
}

/// By rank.
using Numbers = std::map<int, int>;

Payload join(Payload mine, Payload more) {
  auto all = unpacked<Numbers>(std::move(mine));
  all.merge(unpacked<Numbers>(std::move(more)));
  return packed(all);
}

/// Every rank works for a tenth of a second and numbers its bulletins; returns those that rank 0 has read.
std::vector<Numbers> bulletins_of_a_run(Transport& transport) {
  std::vector<Numbers> heard;
  int number = 0;
  const Registry registry = sleepers();
  RuntimeOptions options;
  options.bulletins = {2ms,
                       [&] {
                         return packed(Numbers{{transport.rank().value, number++}});
                       },
                       join, [&](Payload all) { heard.push_back(unpacked<Numbers>(std::move(all))); }};
  Runtime runtime(transport, registry, options);
  runtime.run([](Context& context) { context.invoke<&Sleeper::sleep>(context.create<Sleeper>(), 100); });
  return heard;
}

/// The last rank sets its flag while all work; every rank's handler sees its own set before it ends.
TEST_P(LookingOn, ANoticeOfOneRankReachesAll) {
  struct Watcher {
    void watch(Context& context) {
      while (!context.local<std::atomic<bool>>().load()) std::this_thread::sleep_for(1ms);
    }
  };
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry;
    registry.type<Watcher>("Watcher").method<&Watcher::watch>("watch");
    std::atomic<bool> flag = false;
    RuntimeOptions options;
    options.local = &flag;
    options.notice = &flag;
    Runtime runtime(transport, registry, options);
    runtime.run([&](Context& context) {
      context.invoke<&Watcher::watch>(context.create<Watcher>());
      if (context.rank().value == context.ranks() - 1) flag = true;
    });
    EXPECT_TRUE(flag);
  });
}

TEST_P(LookingOn, RankZeroHearsOfAllWhileTheyWork) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const std::vector<Numbers> heard = bulletins_of_a_run(transport);
    ASSERT_EQ(heard.empty(), transport.rank() != Rank(0));
    if (heard.empty()) return;
    EXPECT_EQ(heard.back().size(), static_cast<std::size_t>(GetParam()));
    for (std::size_t i = 1; i < heard.size(); ++i)
      for (const auto& [from, number] : heard[i - 1])
        EXPECT_GE(heard[i].at(from), number) << "what was said later counts";
  });
}

/// A rank joins what its children say to its own, and hears of no other: rank 0 gets two bulletins.
TEST(Bulletins, AreJoinedOnTheWayToRankZero) {
  constexpr int kRanks = 100;
  std::vector<std::set<int>> first_ranks(kRanks);  // of the bulletins that each rank got
  std::size_t all = 0;                             // ranks that rank 0 has heard of
  simulate({.ranks = kRanks, .measured = false}, [&](Transport& transport) {
    const int rank = transport.rank().value;
    const Registry registry = sleepers();
    RuntimeOptions options;
    options.balancer = no_balancing();
    options.bulletins = {2ms,
                         [&] {
                           return packed(Numbers{{rank, 0}});
                         },
                         [&](Payload mine, Payload more) {
                           auto others = unpacked<Numbers>(std::move(more));
                           first_ranks[transport.rank().index()].insert(others.begin()->first);
                           return join(std::move(mine), packed(std::move(others)));
                         },
                         [&](Payload payload) { all = unpacked<Numbers>(std::move(payload)).size(); }};
    Runtime runtime(transport, registry, options);
    runtime.run([](Context& context) { context.invoke<&Sleeper::sleep>(context.create<Sleeper>(), 100); });
  });
  EXPECT_EQ(all, static_cast<std::size_t>(kRanks));
  for (int rank = 0; rank < kRanks; ++rank) {
    std::set<int> children;
    for (const int child : {2 * rank + 1, 2 * rank + 2})
      if (child < kRanks) children.insert(child);
    EXPECT_EQ(first_ranks[static_cast<std::size_t>(rank)], children) << "rank " << rank;
  }
}

TEST_P(LookingOn, BulletinsThatAreLateDoNotHoldUpTheEnd) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const auto late = delayed(transport, 20ms, 1);
    for (int run = 0; run < 3; ++run) bulletins_of_a_run(*late);
  });
}

TEST(Bulletins, RankZeroReadsInEveryPeriodThoughNobodySaysAnything) {
  on_ranks(2, [&](Transport& transport) {
    std::set<std::size_t> sizes;
    const Registry registry = sleepers();
    RuntimeOptions options;
    options.bulletins = {2ms, [] { return Payload{}; }, join, [&](Payload all) { sizes.insert(all.size()); }};
    Runtime runtime(transport, registry, options);
    runtime.run([](Context& context) { context.invoke<&Sleeper::sleep>(context.create<Sleeper>(), 50); });
    EXPECT_EQ(sizes, transport.rank() == Rank(0) ? std::set<std::size_t>{0} : std::set<std::size_t>{});
  });
}

TEST(Bulletins, BeginWithTheNextRunWhereTheyAreSetLater) {
  on_ranks(2, [&](Transport& transport) {
    Numbers heard;
    const Registry registry = sleepers();
    Runtime runtime(transport, registry);
    const auto work = [](Context& context) {
      context.invoke<&Sleeper::sleep>(context.create<Sleeper>(), 50);
    };
    runtime.run(work);
    runtime.set_bulletins({2ms,
                           [&] {
                             return packed(Numbers{{transport.rank().value, 1}});
                           },
                           join, [&](Payload all) { heard = unpacked<Numbers>(std::move(all)); }});
    runtime.run(work);
    EXPECT_EQ(heard.size(), transport.rank() == Rank(0) ? 2u : 0u);
  });
}

/// Waits for a signal that is given when both ranks have shown their states.
struct Waiter {
  bool met = false;
  void wait_for(Context& context, ObjectId other) { context.expect<&Waiter::meet>(4, {other}); }
  void be_busy_and_call(Context& context, std::vector<ObjectId> others) {
    while (context.local<std::atomic<int>>() < 2) std::this_thread::sleep_for(1ms);
    for (const ObjectId other : others) context.signal<&Waiter::meet>(MobilePtr<Waiter>{other}, 4);
  }
  void meet(Context&, std::uint64_t, std::vector<Arrival<Nothing>>) { met = true; }
  ObjectState describe() const { return {met ? "has met" : "has not met", {}}; }
};

TEST(State, SaysWhatEachObjectDoesAndForWhomItWaits) {
  std::atomic<int> shown{0};  // ranks
  on_ranks(2, [&](Transport& transport) {
    Registry registry;
    registry.type<Waiter>("Waiter")
        .method<&Waiter::wait_for>("wait_for")
        .method<&Waiter::be_busy_and_call>("be_busy_and_call")
        .event<&Waiter::meet>("meet");
    std::string state;
    RuntimeOptions options;
    options.balancer = no_balancing();
    options.local = &shown;
    options.name_of = [](ObjectId id) {
      return "Waiter " + std::to_string(id.home.value) + std::to_string(id.number);
    };
    options.on_state = [&](const std::string& text) { state = text, ++shown; };
    Runtime runtime(transport, registry, options);
    const bool waits = transport.rank() == Rank(1);
    std::jthread asker([&] {
      std::this_thread::sleep_for(100ms);
      runtime.request_state();
    });
    runtime.run([&](Context& context) {
      const auto mine = context.create<Waiter>();
      if (waits) return context.invoke<&Waiter::wait_for>(mine, ObjectId{Rank(0), 1});
      context.invoke<&Waiter::be_busy_and_call>(mine, std::vector{ObjectId{Rank(1), 1}});
    });
    if (waits) {
      EXPECT_THAT(
          state,
          AllOf(HasSubstr("state of rank 1 of 2"), HasSubstr("0 of 1 workers busy"),
                HasSubstr("Waiter 11: has not met, no message to handle; waits in Waiter::meet, round 4, for "
                          "Waiter 01 (rank 0)")));
    } else {
      EXPECT_THAT(state, AllOf(HasSubstr("state of rank 0 of 2"), HasSubstr("1 of 1 workers busy"),
                               HasSubstr("Waiter 01: runs Waiter::be_busy_and_call for 0.")));
    }
  });
}

TEST(State, IsShownInTheNextRunWhenAskedForBetweenRuns) {
  on_ranks(1, [&](Transport& transport) {
    const Registry registry = sleepers();
    int shown = 0;
    RuntimeOptions options;
    options.on_state = [&](const std::string&) { ++shown; };
    Runtime runtime(transport, registry, options);
    runtime.request_state();
    EXPECT_EQ(shown, 0);
    runtime.run([](Context& context) { context.create<Sleeper>(); });
    runtime.run();
    EXPECT_EQ(shown, 1);
  });
}

}  // namespace
}  // namespace weft::engine::looking_on_test

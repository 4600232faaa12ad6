// Task graphs on all numbers of ranks: rounds, dormancy, migration, values of all sizes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <set>
#include <thread>
#include <variant>

#include "engine/balance/balancer.h"
#include "graph/dataflow/blueprint.h"
#include "tests/graph/rounds_game.h"
#include "tests/support/ranks.h"

namespace weft::graph::dataflow::dataflow_test {
namespace {

using engine::Context;
using engine::Registry;
using engine::Runtime;
using engine::Transport;
using ::testing::ElementsAre;
using weft::testing::GameRules;
using weft::testing::is_distributed;
using weft::testing::on_ranks;
using weft::testing::Player;

class DataflowOnRanks : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, DataflowOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

// --- Games of many rounds

struct GameSetting {
  engine::BalancerFactory balancer = engine::no_balancing();
  int threads = 1;
  std::chrono::microseconds delay{0};
};

/// Plays on all ranks and compares each player, wherever it has got to, with the game played by hand.
void expect_game(int ranks, GameRules rules, const GameSetting& setting) {
  rules.ranks = static_cast<std::uint32_t>(ranks);
  const std::vector<std::uint64_t> expected = weft::testing::play_by_hand(rules);
  std::atomic<std::uint32_t> players{0};
  std::atomic<std::uint64_t> woken{0};
  on_ranks(ranks, [&](Transport& network) {
    const auto late = setting.delay.count() > 0 ? weft::testing::delayed(network, setting.delay, 3) : nullptr;
    Registry registry;
    register_blueprint<Player>(registry);
    Runtime runtime(late ? *late : network, registry,
                    {.threads = setting.threads, .balancer = setting.balancer});
    runtime.run([&](Context& context) { start_game(Recording::off, context, rules); });
    EXPECT_THAT(incomplete<Player>(runtime), ElementsAre());
    visit<Player>(runtime, [&](Ref<Player> ref, Player& player) {
      EXPECT_EQ(ref, rules.player(player.index));
      EXPECT_EQ(player.value, expected[player.index]) << "player " << player.index;
      EXPECT_EQ(player.faults, 0u);
      EXPECT_EQ(player.rounds_played, rules.rounds);
      ++players;
      woken += player.woken_in.size();
    });
  });
  if (is_distributed()) return;
  EXPECT_EQ(players, rules.players);
  if (rules.dormancy) {
    EXPECT_GT(woken, 0u);
  }
}

TEST_P(DataflowOnRanks, PlaysRoundsWithChangingNeighbours) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    expect_game(GetParam(), {.players = 17, .rounds = 20, .seed = seed}, {});
  }
}

TEST_P(DataflowOnRanks, PlaysOnSeveralThreads) {
  expect_game(GetParam(), {.players = 24, .rounds = 20, .dormancy = true}, {.threads = 3});
}

TEST_P(DataflowOnRanks, WakesDormantInstances) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    expect_game(GetParam(), {.players = 13, .rounds = 25, .dormancy = true, .seed = seed}, {});
  }
}

TEST_P(DataflowOnRanks, PlaysOverALateNetwork) {
  expect_game(GetParam(), {.players = 12, .rounds = 6, .dormancy = true},
              {.delay = std::chrono::microseconds(2000)});
}

TEST_P(DataflowOnRanks, PlaysWhileEveryInstanceMoves) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    expect_game(GetParam(), {.players = 16, .rounds = 12, .dormancy = true, .seed = seed},
                {.balancer = engine::rotate(1.0, seed + 1)});
  }
}

TEST_P(DataflowOnRanks, PlaysWhileEveryInstanceMovesOverALateNetwork) {
  expect_game(GetParam(), {.players = 12, .rounds = 5, .dormancy = true},
              {.balancer = engine::rotate(), .threads = 2, .delay = std::chrono::microseconds(1000)});
}

TEST_P(DataflowOnRanks, PlaysUnderWorkStealing) {
  expect_game(GetParam(), {.players = 20, .rounds = 10, .dormancy = true},
              {.balancer = engine::work_stealing(), .threads = 2});
}

TEST_P(DataflowOnRanks, LargeValuesArriveWhole) {
  const std::uint32_t megabytes = 3;
  expect_game(GetParam(), {.players = 4, .rounds = 2, .ballast = megabytes << 17}, {});
}

TEST_P(DataflowOnRanks, LargeValuesTravelWithAnInstanceThatMoves) {
  expect_game(GetParam(), {.players = 6, .rounds = 3, .ballast = 1 << 16, .dormancy = true},
              {.balancer = engine::rotate()});
}

TEST_P(DataflowOnRanks, AGameOfOneHasNobodyToWaitFor) {
  expect_game(GetParam(), {.players = 1, .rounds = 7}, {});
}

// --- A local pipeline

/// measure -> scale (if there is something) -> collect, tally; measure -> tally.
struct Pipeline {
  std::vector<std::string> calls;
  double total = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(calls, total);
  }
  std::optional<std::vector<double>> measure(NodeContext&, const std::vector<double>& values) {
    calls.push_back("measure");
    return values.empty() ? std::nullopt : std::make_optional(values);
  }
  std::vector<double> scale(NodeContext&, std::vector<double> values) {
    calls.push_back("scale");
    for (double& value : values) value *= 2;
    return values;
  }
  void collect(NodeContext& context, const std::vector<double>& values) {
    calls.push_back("collect in round " + std::to_string(context.round()));
    total += std::accumulate(values.begin(), values.end(), 0.0);
  }
  void tally(NodeContext&, std::vector<double> values) {
    calls.push_back("tally of " + std::to_string(static_cast<int>(values.at(0))));
  }
  void finish(NodeContext&) { calls.push_back("finish"); }

  static Blueprint<Pipeline> blueprint() {
    Blueprint<Pipeline> g("pipeline");
    const auto measure = g.start<&Pipeline::measure>("measure");
    const auto scale = g.node<&Pipeline::scale>("scale");
    const auto collect = g.node<&Pipeline::collect>("collect");
    const auto tally = g.node<&Pipeline::tally>("tally");
    const auto finish = g.node<&Pipeline::finish>("finish");
    g.local(measure, scale);
    g.local(scale, collect, RoundStep::next);
    g.local(measure, tally);
    g.local(collect, finish);
    return g;
  }
};

TEST(Dataflow, LocalNodesRunInTheOrderOfTheirEdges) {
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Pipeline>(registry);
    Runtime runtime(transport, registry, {.threads = 4});
    runtime.run([&](Context& context) {
      start<&Pipeline::measure>(context, create<Pipeline>(context), 5, {1.0, 2.0});
    });
    visit<Pipeline>(runtime, [&](Ref<Pipeline>, Pipeline& pipeline) {
      EXPECT_EQ(pipeline.total, 6.0);
      EXPECT_THAT(pipeline.calls,
                  ElementsAre("measure", "scale", "collect in round 6", "finish", "tally of 1"));
    });
  });
}

TEST(Dataflow, AnEmptyOptionalPassesNothingOn) {
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Pipeline>(registry);
    Runtime runtime(transport, registry);
    runtime.run([&](Context& context) { start<&Pipeline::measure>(context, create<Pipeline>(context)); });
    visit<Pipeline>(runtime, [&](Ref<Pipeline>, Pipeline& pipeline) {
      EXPECT_THAT(pipeline.calls, ElementsAre("measure"));
    });
  });
}

/// Odd numbers go to one node, even ones to another, as text; either way a third, which takes nothing, runs.
struct Switch {
  std::vector<std::string> calls;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(calls);
  }
  std::variant<int, std::string> sort(NodeContext&, int value) {
    if (value % 2 == 1) return value;
    return std::to_string(value);
  }
  void count(NodeContext& context, int value) {
    calls.push_back("odd " + std::to_string(value) + " in round " + std::to_string(context.round()));
  }
  std::optional<int> read(NodeContext&, const std::string& text) {
    calls.push_back("even " + text);
    return std::stoi(text) + 1;
  }
  void always(NodeContext&) { calls.push_back("always"); }
  static Blueprint<Switch> blueprint() {
    Blueprint<Switch> g("switch");
    const auto sort = g.start<&Switch::sort>("sort");
    const auto count = g.node<&Switch::count>("count");
    const auto read = g.node<&Switch::read>("read");
    g.local(sort, count, RoundStep::next);
    g.local(sort, read);
    g.local(read, count);
    g.local(sort, g.node<&Switch::always>("always"));
    return g;
  }
};

std::vector<std::string> calls_of_switch(int value, ExecutionLog& log) {
  std::vector<std::string> calls;
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Switch>(registry);
    Runtime runtime(transport, registry);
    runtime.run([&](Context& context) {
      start<&Switch::sort>(context, create<Switch>(context, {}, Recording::on), 7, value);
    });
    visit<Switch>(runtime, [&](Ref<Switch>, Switch& s) { calls = s.calls; });
    log = log_of<Switch>(runtime);
  });
  return calls;
}

TEST(Dataflow, AVariantGoesToTheNodesThatTakeWhatItHolds) {
  const auto used = [](const ExecutionLog& log) {
    std::set<std::string> names;
    for (const EdgeUse& use : log.uses)
      names.insert(blueprint_of<Switch>().description().edges[use.edge].name);
    return names;
  };
  ExecutionLog odd, even;
  EXPECT_THAT(calls_of_switch(3, odd), ElementsAre("always", "odd 3 in round 8"));
  EXPECT_THAT(used(odd), ElementsAre("sort -> always", "sort -> count"));
  EXPECT_THAT(calls_of_switch(4, even), ElementsAre("even 4", "odd 5 in round 7", "always"));
  EXPECT_THAT(used(even), ElementsAre("read -> count", "sort -> always", "sort -> read"));
}

/// As Switch, but 0 goes nowhere.
struct Sieve {
  std::vector<std::string> calls;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(calls);
  }
  std::optional<std::variant<int, std::string>> sort(NodeContext&, int value) {
    if (value == 0) return std::nullopt;
    if (value % 2 == 1) return value;
    return std::to_string(value);
  }
  void count(NodeContext&, int value) { calls.push_back("odd " + std::to_string(value)); }
  void read(NodeContext&, const std::string& text) { calls.push_back("even " + text); }
  static Blueprint<Sieve> blueprint() {
    Blueprint<Sieve> g("sieve");
    const auto sort = g.start<&Sieve::sort>("sort");
    g.local(sort, g.node<&Sieve::count>("count"));
    g.local(sort, g.node<&Sieve::read>("read"));
    return g;
  }
};

TEST(Dataflow, AnOptionalVariantGoesToTheNodesThatTakeWhatItHoldsOrNowhere) {
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Sieve>(registry);
    Runtime runtime(transport, registry);
    runtime.run([&](Context& context) {
      const auto sieve = create<Sieve>(context);
      for (const int value : {3, 0, 4}) start<&Sieve::sort>(context, sieve, 0, value);
    });
    visit<Sieve>(runtime,
                 [&](Ref<Sieve>, Sieve& sieve) { EXPECT_THAT(sieve.calls, ElementsAre("odd 3", "even 4")); });
  });
}

/// Move-only values pass from node to node.
struct Relay {
  double result = 0;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(result);
  }
  std::unique_ptr<double> make(NodeContext&, double value) { return std::make_unique<double>(value); }
  void use(NodeContext&, std::unique_ptr<double> value) { result = *value; }
  static Blueprint<Relay> blueprint() {
    Blueprint<Relay> g("relay");
    g.local(g.start<&Relay::make>("make"), g.node<&Relay::use>("use"));
    return g;
  }
};

TEST(Dataflow, ValuesOfLocalEdgesNeedNotBeCopyable) {
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Relay>(registry);
    Runtime runtime(transport, registry);
    runtime.run([&](Context& context) { start<&Relay::make>(context, create<Relay>(context), 0, 2.5); });
    visit<Relay>(runtime, [&](Ref<Relay>, Relay& relay) { EXPECT_EQ(relay.result, 2.5); });
  });
}

// --- Arrivals that wait while their instance moves

/// Values come before anybody expects them, the instance moves with them, then they are expected.
struct Collector {
  std::vector<std::uint32_t> order;
  std::uint64_t sum = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(order, sum);
  }
  void give(NodeContext& context, Ref<Collector> to) {
    context.send<&Collector::collect>(to, 3, std::vector<std::uint64_t>(5000, context.self().number));
  }
  void ask(NodeContext& context, std::vector<Ref<Collector>> from) {
    context.expect<&Collector::collect>(3, from);
  }
  void collect(NodeContext&, std::uint64_t, std::vector<Arrival<std::vector<std::uint64_t>>> values) {
    for (const auto& arrival : values) {
      order.push_back(arrival.from.number);
      sum += std::accumulate(arrival.value.begin(), arrival.value.end(), std::uint64_t{0});
    }
  }
  static Blueprint<Collector> blueprint() {
    Blueprint<Collector> g("collector");
    const auto give = g.start<&Collector::give>("give");
    g.start<&Collector::ask>("ask");
    const auto collect = g.event<&Collector::collect>("collect");
    g.remote<std::vector<std::uint64_t>>(give, collect);
    return g;
  }
};

TEST_P(DataflowOnRanks, ArrivalsMoveWithTheirInstanceAndComeInTheDeclaredOrder) {
  std::atomic<int> found{0};
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry;
    register_blueprint<Collector>(registry);
    Runtime runtime(transport, registry, {.balancer = engine::no_balancing()});
    const Ref<Collector> target{{engine::Rank(0), 1}};
    const auto giver = [](std::uint32_t number) { return Ref<Collector>{{engine::Rank(0), number}}; };
    const auto at_root = [&](const auto& act) {
      runtime.run([&](Context& context) {
        if (context.rank() == engine::Rank(0)) act(context);
      });
    };
    at_root([&](Context& context) {
      for (int i = 0; i < 5; ++i) create<Collector>(context);
      for (const std::uint32_t i : {2u, 3u, 4u, 5u}) start<&Collector::give>(context, giver(i), 0, target);
    });
    for (int rank = GetParam() - 1; rank >= 0; --rank) {
      at_root([&](Context& context) { context.migrate(target, engine::Rank(rank)); });
      at_root([&](Context& context) { context.migrate(giver(3), engine::Rank(rank)); });
    }
    at_root([&](Context& context) {
      context.migrate(target, engine::Rank(GetParam() - 1));
      start<&Collector::ask>(context, target, 0, {giver(4), giver(2), giver(5), giver(3)});
    });
    visit<Collector>(runtime, [&](Ref<Collector> ref, Collector& collector) {
      if (ref != target) return;
      ++found;
      EXPECT_EQ(transport.rank(), engine::Rank(GetParam() - 1));
      EXPECT_THAT(collector.order, ElementsAre(4u, 2u, 5u, 3u));
      EXPECT_EQ(collector.sum, 5000u * (2 + 3 + 4 + 5));
    });
  });
  if (!is_distributed()) {
    EXPECT_EQ(found, 1);
  }
}

TEST(Dataflow, TellsWhichEventsLackArrivals) {
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Collector>(registry);
    Runtime runtime(transport, registry);
    const auto nth = [](std::uint32_t number) { return Ref<Collector>{{engine::Rank(0), number}}; };
    runtime.run([&](Context& context) {
      for (int i = 0; i < 4; ++i) create<Collector>(context);
      start<&Collector::give>(context, nth(2), 0, nth(1));
      start<&Collector::ask>(context, nth(1), 0, {nth(4), nth(2), nth(3)});
      start<&Collector::give>(context, nth(2), 0, nth(3));  // nobody has asked for it
    });
    EXPECT_THAT(incomplete<Collector>(runtime),
                ElementsAre("object 0.1: collect in round 3 waits for 0.4 0.3",
                            "object 0.3: collect in round 3 is not declared for the values of 0.2"));
  });
}

// --- What the balancer knows

/// The largest load that any rank has had.
std::atomic<double> largest_load{0};

class LoadWatcher final : public engine::Balancer {
 public:
  void step(engine::BalanceActions& actions, engine::TimePoint time) override {
    largest_load = std::max(largest_load.load(), actions.load().queued_seconds);
    next_ = time + 100'000;
  }
  void told(engine::Rank, const engine::BalanceMessage&, engine::BalanceActions&) override {}
  std::optional<engine::TimePoint> next_step() const override { return next_; }

 private:
  std::optional<engine::TimePoint> next_ = 0;
};

/// Occupies the only worker until the balancer has seen the work that waits.
struct Planner {
  template <class Archive>
  void serialize(Archive&) {}
  static void wait_for_load(double seconds) {
    while (largest_load < seconds) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  void plan(NodeContext& context) {
    context.expect<&Planner::work>(1, {}, engine::Seconds{500});
    wait_for_load(400);
  }
  void work(NodeContext&, std::uint64_t, std::vector<Arrival<Nothing>>) {}
  static Blueprint<Planner> blueprint() {
    Blueprint<Planner> g("planner");
    g.start<&Planner::plan>("plan");
    g.event<&Planner::work>("work");
    return g;
  }
};

TEST(Dataflow, TheBalancerSeesWhatStartsAndEventsWillCost) {
  on_ranks(1, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Planner>(registry);
    Runtime runtime(transport, registry, {.threads = 1, .balancer = [](engine::Rank, int) {
                                            return std::make_unique<LoadWatcher>();
                                          }});
    runtime.run([&](Context& context) {
      start<&Planner::plan>(context, create<Planner>(context), 0, {}, engine::Seconds{50});
      Planner::wait_for_load(40);
      EXPECT_LT(largest_load, 400);
    });
    EXPECT_GE(largest_load, 400);
  });
}

}  // namespace
}  // namespace weft::graph::dataflow::dataflow_test

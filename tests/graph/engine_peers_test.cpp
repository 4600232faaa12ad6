// Exchanges between all ranks, of all sizes, many in a row.
#include "graph/adaptation/engine_peers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "engine/simulate/simulation.h"
#include "partition/communication/reduce.h"
#include "tests/graph/rounds_game.h"
#include "tests/support/ranks.h"

namespace weft::graph::adaptation::engine_peers_test {
namespace {

using engine::Registry;
using engine::Runtime;
using engine::Transport;
using ::testing::HasSubstr;
using weft::testing::kSlowness;
using weft::testing::on_ranks;

class EnginePeersOnRanks : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, EnginePeersOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

Registry registry_with_peers() {
  Registry registry;
  EnginePeers::register_types(registry);
  return registry;
}

/// What rank `from` sends to rank `to` in an exchange: both can make it up. Often nothing, seldom a lot.
partition::Bytes message(int exchange, int from, int to, std::size_t longest) {
  std::mt19937 random(static_cast<unsigned>((exchange * 64 + from) * 64 + to));
  const std::size_t kind = random() % 4;
  const std::size_t size = kind == 0 ? 0 : random() % (kind == 3 ? longest : 100);
  partition::Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

void expect_exchanges(partition::Peers& peers, int exchanges, std::size_t longest) {
  for (int exchange = 0; exchange < exchanges; ++exchange) {
    std::vector<partition::Bytes> to_each;
    std::vector<partition::Bytes> expected;
    for (int other = 0; other < peers.ranks(); ++other) {
      to_each.push_back(message(exchange, peers.rank(), other, longest));
      expected.push_back(message(exchange, other, peers.rank(), longest));
    }
    ASSERT_TRUE(peers.all_to_all(std::move(to_each)) == expected) << "exchange " << exchange;
  }
}

TEST_P(EnginePeersOnRanks, ManyExchangesNeverMix) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = registry_with_peers();
    Runtime runtime(transport, registry);
    EnginePeers peers(runtime);
    EXPECT_EQ(peers.rank(), transport.rank().value);
    EXPECT_EQ(peers.ranks(), GetParam());
    expect_exchanges(peers, 100 / kSlowness, 30'000);
  });
}

TEST_P(EnginePeersOnRanks, ALateNetworkChangesNothing) {
  on_ranks(GetParam(), [&](Transport& network) {
    const auto late = weft::testing::delayed(network, std::chrono::microseconds(500), 11);
    const Registry registry = registry_with_peers();
    Runtime runtime(*late, registry, {.balancer = engine::rotate()});
    EnginePeers peers(runtime);
    expect_exchanges(peers, 10, 30'000);
  });
}

TEST_P(EnginePeersOnRanks, LargeMessagesArriveWhole) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = registry_with_peers();
    Runtime runtime(transport, registry);
    EnginePeers peers(runtime);
    expect_exchanges(peers, 3, 4'000'000);
  });
}

TEST_P(EnginePeersOnRanks, ServesTheTypedExchange) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = registry_with_peers();
    Runtime runtime(transport, registry);
    EnginePeers peers(runtime);
    const auto ranks = static_cast<std::size_t>(GetParam());
    std::vector<std::vector<int>> to_each(ranks);
    for (std::size_t to = 0; to < ranks; ++to) to_each[to].assign(to, peers.rank());
    const auto received = partition::all_to_all<int>(peers, to_each);
    ASSERT_EQ(received.size(), ranks);
    for (std::size_t from = 0; from < ranks; ++from) {
      const auto length = static_cast<std::size_t>(peers.rank());
      EXPECT_EQ(received[from], std::vector<int>(length, static_cast<int>(from)));
    }
  });
}

TEST_P(EnginePeersOnRanks, ExchangesBeforeAndAfterOtherWork) {
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry = registry_with_peers();
    dataflow::register_blueprint<weft::testing::Player>(registry);
    Runtime runtime(transport, registry, {.balancer = engine::rotate()});
    EnginePeers peers(runtime);
    expect_exchanges(peers, 3, 1000);
    runtime.run([&](engine::Context& context) {
      weft::testing::start_game(dataflow::Recording::off, context,
                                {.players = 8, .rounds = 3, .first_number = 2});
    });
    EnginePeers others(runtime);  // the same mailboxes
    expect_exchanges(others, 3, 1000);
    expect_exchanges(peers, 3, 1000);
  });
}

int steps_for(int ranks) {
  int steps = 0;
  while (1 << steps < ranks) ++steps;
  return steps;
}

/// In a simulation, since there are many; large payloads too, from each rank to the next.
TEST(EnginePeersOnManyRanks, SmallPayloadsTakeAMessageAStepWhoeverSendsToWhom) {
  constexpr std::size_t kLarge = 2 * dataflow::RankExchange::kDirectBytes;
  for (const int ranks : {2, 5, 64, 150 / kSlowness}) {
    engine::simulate({.ranks = ranks}, [&](Transport& transport) {
      const Registry registry = registry_with_peers();
      Runtime runtime(transport, registry);
      EnginePeers peers(runtime);
      const engine::RankSummary before = runtime.summary();
      const int rank = peers.rank(), next = (rank + 1) % ranks;
      std::vector<partition::Bytes> to_each;
      for (int to = 0; to < ranks; ++to)
        to_each.emplace_back(to == next ? kLarge : 1, static_cast<std::byte>(rank - to));
      const std::vector<partition::Bytes> arrived = peers.all_to_all(to_each);
      for (int from = 0; from < ranks; ++from)
        ASSERT_TRUE(
            arrived[static_cast<std::size_t>(from)] ==
            partition::Bytes((from + 1) % ranks == rank ? kLarge : 1, static_cast<std::byte>(from - rank)));
      const engine::Exchanged small_and_large = engine::exchanged_between(before, runtime.summary());
      const auto steps = static_cast<std::uint64_t>(steps_for(ranks));
      EXPECT_EQ(small_and_large.messages, steps + 1);
      EXPECT_LE(small_and_large.peers, 2 * steps);
    });
  }
}

TEST(EnginePeersOnManyRanks, GatheringsAndReductionsTakeAMessageAStep) {
  constexpr int kRanks = 100 / kSlowness;
  engine::simulate({.ranks = kRanks}, [&](Transport& transport) {
    const Registry registry = registry_with_peers();
    Runtime runtime(transport, registry);
    EnginePeers peers(runtime);
    const engine::RankSummary before = runtime.summary();
    const int rank = peers.rank();
    const auto all = partition::allgather(peers, std::vector<int>(rank % 3, rank));
    for (int r = 0; r < kRanks; ++r) ASSERT_EQ(all[static_cast<std::size_t>(r)], std::vector<int>(r % 3, r));
    std::vector<int> many(10'000, rank);  // as long as many ranks' payloads that go straight
    many = partition::max(peers, many);
    EXPECT_EQ(many, std::vector<int>(10'000, kRanks - 1));
    const engine::Exchanged exchanged = engine::exchanged_between(before, runtime.summary());
    const auto steps =
        static_cast<std::uint64_t>(steps_for(kRanks));  // one to the rank beyond 64, or from it
    EXPECT_LE(exchanged.messages, 2 * steps);
    EXPECT_LE(exchanged.peers, steps);
  });
}

/// Idle ranks ask nobody for work, and nobody waits for the others' end. A run begins and ends with a sign
/// of life to the next.
TEST(EnginePeersOnManyRanks, AReductionTakesAsLongAsItsSteps) {
  constexpr int kRanks = 64, kSteps = 6;
  constexpr double kLatency = 50e-6;
  const auto simulate_reductions = [&](int reductions) {
    const auto reduce = [&](Transport& transport) {
      const Registry registry = registry_with_peers();
      Runtime runtime(transport, registry);
      EnginePeers peers(runtime);
      for (int i = 0; i < reductions; ++i) ASSERT_EQ(partition::sum(peers, 1), kRanks);
    };
    return engine::simulate({.ranks = kRanks, .network = {.latency = kLatency}, .measured = false}, reduce);
  };
  const engine::SimulationResult one = simulate_reductions(1), eleven = simulate_reductions(11);
  EXPECT_LE(eleven.packets - one.packets, 10u * kRanks * (kSteps + 2));
  EXPECT_LE(eleven.seconds - one.seconds, 10 * kSteps * 1.2 * kLatency);
}

/// Its receiver knows of it before it comes.
TEST_P(EnginePeersOnRanks, ALargePayloadAloneIsWaitedFor) {
  on_ranks(GetParam(), [&](Transport& network) {
    const auto late = weft::testing::delayed(network, std::chrono::microseconds(500), 5);
    const Registry registry = registry_with_peers();
    Runtime runtime(*late, registry);
    EnginePeers peers(runtime);
    for (int time = 0; time < 10; ++time) {
      const int last = GetParam() - 1;
      std::vector<partition::Bytes> to_each(static_cast<std::size_t>(GetParam()));
      if (peers.rank() == 0)
        to_each.back().assign(dataflow::RankExchange::kDirectBytes + 1, static_cast<std::byte>(time));
      const std::size_t expected = peers.rank() == last ? dataflow::RankExchange::kDirectBytes + 1 : 0;
      const std::vector<partition::Bytes> arrived = peers.all_to_all(std::move(to_each));
      ASSERT_EQ(arrived[0], partition::Bytes(expected, static_cast<std::byte>(time)));
    }
  });
}

/// The failure of `act`, which must fail on every rank.
template <class Act>
std::string failure_of(const Act& act) {
  try {
    act();
  } catch (const engine::RunFailure& failure) {
    return failure.what();
  }
  return "no failure";
}

TEST_P(EnginePeersOnRanks, MustBeTheFirstToMakeObjects) {
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry = registry_with_peers();
    dataflow::register_blueprint<weft::testing::Player>(registry);
    Runtime runtime(transport, registry, {.on_failure = [](const std::string&) {}});
    runtime.run([&](engine::Context& context) { dataflow::create<weft::testing::Player>(context); });
    EXPECT_THAT(failure_of([&] { EnginePeers peers(runtime); }),
                HasSubstr("a rank's mailbox must be its first object, but has the number 2"));
  });
}

TEST_P(EnginePeersOnRanks, RefusesAMessageTooMany) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = registry_with_peers();
    Runtime runtime(transport, registry, {.on_failure = [](const std::string&) {}});
    EnginePeers peers(runtime);
    const auto ranks = static_cast<std::size_t>(GetParam());
    EXPECT_THAT(failure_of([&] { peers.all_to_all(std::vector<partition::Bytes>(ranks + 1)); }),
                HasSubstr(std::to_string(ranks + 1) + " payloads for " + std::to_string(ranks) + " ranks"));
  });
}

}  // namespace
}  // namespace weft::graph::adaptation::engine_peers_test

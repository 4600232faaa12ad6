// What is recorded is what happened: every use of an edge belongs to a run of the node at each of its ends.
#include "graph/dataflow/execution_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <tuple>

#include "graph/dataflow/common_clock.h"
#include "graph/dataflow/rank_exchange.h"
#include "tests/graph/rounds_game.h"
#include "tests/support/ranks.h"

namespace weft::graph::dataflow::execution_log_test {
namespace {

using engine::Context;
using engine::Registry;
using engine::Runtime;
using engine::Transport;
using weft::testing::GameRules;
using weft::testing::is_distributed;
using weft::testing::on_ranks;
using weft::testing::Player;
using weft::testing::start_game;

class ExecutionLogOnRanks : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, ExecutionLogOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

const GraphDescription& game() { return blueprint_of<Player>().description(); }

NodeIndex node_named(const std::string& name) {
  const auto& nodes = game().nodes;
  const auto found =
      std::find_if(nodes.begin(), nodes.end(), [&](const NodeDescription& n) { return n.name == name; });
  return static_cast<NodeIndex>(found - nodes.begin());
}

using RunKey = std::tuple<engine::ObjectId, NodeIndex, std::uint64_t>;

/// The runs by instance, node and round; in this game each occurs at most once.
std::multimap<RunKey, NodeRun> by_key(const ExecutionLog& log) {
  std::multimap<RunKey, NodeRun> runs;
  for (const NodeRun& run : log.runs) runs.emplace(RunKey{run.instance, run.node, run.round}, run);
  return runs;
}

/// Each use lies between a run of the edge's first node and one of its second; `one_clock`: times can be
/// compared across ranks.
void expect_uses_within_runs(const ExecutionLog& log, bool one_clock) {
  const auto runs = by_key(log);
  for (const EdgeUse& use : log.uses) {
    const EdgeDescription& edge = game().edges.at(use.edge);
    SCOPED_TRACE(edge.name);
    const std::uint64_t left_in = use.round - (edge.step == RoundStep::next ? 1 : 0);
    const auto from = runs.equal_range({use.from, edge.from, left_in});
    ASSERT_EQ(std::distance(from.first, from.second), 1);
    EXPECT_EQ(from.first->second.rank, use.rank);
    EXPECT_LE(from.first->second.begin, use.time);
    EXPECT_LE(use.time, from.first->second.end);
    const auto to = runs.equal_range({use.to, edge.to, use.round});
    ASSERT_EQ(std::distance(to.first, to.second), 1);
    if (one_clock) {
      EXPECT_LE(use.time, to.first->second.begin);
    }
    EXPECT_EQ(use.bytes > 0, edge.kind == EdgeKind::remote);
    EXPECT_EQ(use.from == use.to, edge.kind == EdgeKind::local);
  }
}

/// An event has received exactly the uses that end at it.
void expect_bytes_to_agree(const ExecutionLog& log, const GameRules& rules) {
  std::map<RunKey, std::pair<std::uint64_t, std::uint64_t>> count_and_bytes;
  for (const EdgeUse& use : log.uses) {
    auto& [count, bytes] = count_and_bytes[{use.to, game().edges[use.edge].to, use.round}];
    ++count;
    bytes += use.bytes;
  }
  double processor_seconds = 0;
  for (const NodeRun& run : log.runs) {
    const NodeKind kind = game().nodes.at(run.node).kind;
    const auto [count, bytes] = count_and_bytes[{run.instance, run.node, run.round}];
    EXPECT_EQ(run.bytes_received, bytes);
    // A thread gets no more of a processor than all of it, up to a tick of the clock by which the kernel
    // counts.
    EXPECT_LE(log.counter(run, kProcessorSeconds), 1e-9 * static_cast<double>(run.end - run.begin) + 4e-3);
    // On a virtual machine the kernel takes time that others had off it, at times all of a short run.
    EXPECT_GE(log.counter(run, kProcessorSeconds), 0);
    processor_seconds += log.counter(run, kProcessorSeconds);
    if (kind == NodeKind::interior) {
      EXPECT_EQ(count, 1u);
    }
    if (run.node != node_named("gather")) continue;
    const auto index = (run.instance.number - rules.first_number) * rules.ranks +
                       static_cast<std::uint32_t>(run.instance.home.value);
    EXPECT_EQ(count, rules.neighbours(index, run.round).size());
    EXPECT_EQ(log.counter(run, "values"), static_cast<double>(count) + 1);
    EXPECT_EQ(log.counter(run, "rounds"), 1);
    EXPECT_EQ(log.counter(run, "no such counter"), 0);
  }
  EXPECT_GT(processor_seconds, 0);
}

void expect_sums(const ExecutionLog& log, const GameRules& rules) {
  const std::vector<NodeSum> sums = sums_of(game(), log);
  ASSERT_EQ(sums.size(), game().nodes.size());
  for (const char* name : {"propose", "gather", "scatter"}) {
    EXPECT_EQ(sums[node_named(name)].node, name);
    EXPECT_EQ(sums[node_named(name)].count, rules.players * rules.rounds);
  }
  EXPECT_EQ(sums[node_named("enter")].count, rules.players * (rules.rounds + 1));
  for (const NodeSum& sum : sums) {
    EXPECT_GE(sum.seconds, sum.longest);
    EXPECT_GE(sum.longest * static_cast<double>(sum.count), sum.seconds * (1 - 1e-12));
  }
}

/// Runs of one instance follow one another.
void expect_runs_one_at_a_time(const ExecutionLog& log) {
  std::map<engine::ObjectId, engine::TimePoint> last;
  for (const NodeRun& run : log.runs) {
    EXPECT_LE(run.begin, run.end);
    EXPECT_LE(last[run.instance], run.begin);
    last[run.instance] = run.end;
  }
}

void expect_consistent_log(int ranks, const engine::BalancerFactory& balancer) {
  GameRules rules{.players = 14, .ranks = static_cast<std::uint32_t>(ranks), .rounds = 8, .first_number = 2};
  rules.dormancy = true;
  std::mutex mutex;
  ExecutionLog together;  // of ranks that share this process and its clock
  on_ranks(ranks, [&](Transport& transport) {
    Registry registry;
    register_blueprint<Player>(registry);
    RankExchange::register_types(registry);
    Runtime runtime(transport, registry, {.balancer = balancer});
    RankExchange exchange(runtime);
    runtime.run([&](Context& context) { start_game(Recording::on, context, rules); });
    ExecutionLog mine = log_of<Player>(runtime);
    {
      const std::lock_guard lock(mutex);
      together.append(ExecutionLog(mine));
    }
    const ExecutionLog all = gather_log(exchange, std::move(mine));
    if (transport.rank() != engine::Rank(0)) {
      EXPECT_TRUE(all.runs.empty() && all.uses.empty());
      return;
    }
    expect_uses_within_runs(all, /*one_clock=*/false);
    expect_bytes_to_agree(all, rules);
    expect_sums(all, rules);
  });
  if (is_distributed()) return;
  expect_uses_within_runs(together, /*one_clock=*/true);
  expect_bytes_to_agree(together, rules);
  expect_runs_one_at_a_time(together);
}

TEST_P(ExecutionLogOnRanks, AgreesWithItself) { expect_consistent_log(GetParam(), engine::no_balancing()); }

TEST_P(ExecutionLogOnRanks, TravelsWithInstancesThatMove) {
  expect_consistent_log(GetParam(), engine::rotate());
}

TEST(ExecutionLog, IsEmptyWhenNothingIsRecorded) {
  on_ranks(1, [](Transport& transport) {
    Registry registry;
    register_blueprint<Player>(registry);
    Runtime runtime(transport, registry);
    runtime.run([&](Context& context) { start_game(Recording::off, context, {.players = 3, .rounds = 2}); });
    const ExecutionLog log = log_of<Player>(runtime);
    EXPECT_TRUE(log.runs.empty() && log.uses.empty() && log.counters.empty());
  });
}

TEST(ExecutionLog, JoinsCountersByName) {
  const auto log_with = [](std::initializer_list<std::pair<const char*, double>> counts) {
    ExecutionLog log;
    log.runs.push_back({});
    for (const auto& [name, amount] : counts) log.count(name, amount);
    return log;
  };
  ExecutionLog all = log_with({{"tets", 3}, {"edges", 5}, {"tets", 1}});
  all.append(log_with({{"edges", 7}, {"faces", 2}}));
  EXPECT_THAT(all.counter_names, ::testing::ElementsAre("tets", "edges", "faces"));
  ASSERT_EQ(all.runs.size(), 2u);
  EXPECT_EQ(all.counter(all.runs[0], "tets"), 4);
  EXPECT_EQ(all.counter(all.runs[0], "edges"), 5);
  EXPECT_EQ(all.counter(all.runs[1], "edges"), 7);
  EXPECT_EQ(all.counter(all.runs[1], "faces"), 2);
  EXPECT_EQ(all.counter(all.runs[1], "tets"), 0);
}

/// An instance that moves takes its log along.
TEST(CommonClock, ShiftsWhatHappenedByTheRankWhereItDid) {
  ExecutionLog log;
  log.runs.resize(2);
  log.runs[0].rank = engine::Rank(1), log.runs[0].begin = 5, log.runs[0].end = 9;
  log.runs[1].rank = engine::Rank(0), log.runs[1].begin = 1020, log.runs[1].end = 1030;
  log.uses.resize(2);
  log.uses[0].rank = engine::Rank(1), log.uses[0].time = 8;
  log.uses[1].rank = engine::Rank(0), log.uses[1].time = 1021;
  to_common_clock({0, 1000}, log);
  EXPECT_EQ(log.runs[0].begin, 1005);
  EXPECT_EQ(log.runs[0].end, 1009);
  EXPECT_EQ(log.runs[1].begin, 1020);
  EXPECT_EQ(log.runs[1].end, 1030);
  EXPECT_EQ(log.uses[0].time, 1008);
  EXPECT_EQ(log.uses[1].time, 1021);
  EXPECT_THROW(to_common_clock({0}, log), std::out_of_range) << "there is no rank 1";
}

TEST(RankExchange, GathersAndReduces) {
  for (const int ranks : {1, 2, 3, 5, 7, 12, 16}) {
    on_ranks(ranks, [&](Transport& transport) {
      Registry registry;
      RankExchange::register_types(registry);
      Runtime runtime(transport, registry, {});
      RankExchange exchange(runtime);
      const int rank = transport.rank().value;
      for (int time = 0; time < 3; ++time) {
        const auto value = [&](int r) {
          return RankExchange::Bytes(static_cast<std::size_t>(r % 4), std::byte(r + time));
        };
        const std::vector<RankExchange::Bytes> all = exchange.allgather(value(rank));
        ASSERT_EQ(all.size(), static_cast<std::size_t>(ranks));
        for (int r = 0; r < ranks; ++r) EXPECT_EQ(all[static_cast<std::size_t>(r)], value(r)) << r;
        RankExchange::Bytes joined;
        for (const RankExchange::Bytes& one : all) joined.insert(joined.end(), one.begin(), one.end());
        EXPECT_EQ(exchange.allgather_joined(value(rank)), joined);
        const auto sum = exchange.reduce({std::byte(rank + time)}, [](auto& whole, const auto& more) {
          whole[0] = std::byte(std::to_integer<int>(whole[0]) + std::to_integer<int>(more[0]));
        });
        EXPECT_EQ(sum, RankExchange::Bytes{std::byte(ranks * (ranks - 1) / 2 + ranks * time)});
        // Also where the order matters all get the same, of each rank once.
        const auto in_order = exchange.reduce({std::byte(rank)}, [](auto& whole, const auto& more) {
          whole.insert(whole.end(), more.begin(), more.end());
        });
        for (const RankExchange::Bytes& of_rank : exchange.allgather(in_order)) EXPECT_EQ(of_rank, in_order);
        const std::set<std::byte> different(in_order.begin(), in_order.end());
        EXPECT_EQ(in_order.size(), static_cast<std::size_t>(ranks));
        EXPECT_EQ(different.size(), static_cast<std::size_t>(ranks));
      }
    });
  }
}

}  // namespace
}  // namespace weft::graph::dataflow::execution_log_test

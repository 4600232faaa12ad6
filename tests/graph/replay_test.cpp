// Recorded graphs on simulated ranks.
#include "graph/replay/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "graph/dataflow/dump/critical_path.h"
#include "graph/replay/replay_plan.h"
#include "tests/support/simulated_run.h"

namespace weft::graph::replay {
namespace {

using dataflow::GraphDump;

GraphDump recorded(std::uint32_t subdomains, std::uint32_t rounds = 4) {
  const weft::testing::SimulationRules rules{.subdomains = subdomains, .rounds = rounds, .seed = 3};
  const weft::testing::SimulatedRun run = weft::testing::simulate(rules);
  return executed_dump(run.graph, run.log,
                       [&](engine::ObjectId id) { return subdomain_of_object(rules, id); });
}

/// Two instances: the first works for 1 ms, sends 1 MB after half of it; the second works for 2 ms upon that.
GraphDump chain() {
  GraphDump dump;
  dump.description = {"pair",
                      {{"begin", dataflow::NodeKind::start}, {"end", dataflow::NodeKind::event}},
                      {{"begin -> end", dataflow::EdgeKind::remote, 0, 1, dataflow::RoundStep::same, "int"}}};
  dump.instances = {{0, {engine::Rank(0), 1}, engine::Rank(0)}, {1, {engine::Rank(0), 2}, engine::Rank(0)}};
  dump.runs.resize(2);
  dump.runs[0].end = 1'000'000;
  dump.runs[1].node = dump.runs[1].instance = 1;
  dump.runs[1].begin = 1'000'000;
  dump.runs[1].end = 3'000'000;
  dump.uses = {{.edge = 0, .from = 0, .to = 1, .time = 500'000, .bytes = 1'000'000}};
  return dump;
}

TEST(Replay, A_value_takes_the_network_from_where_it_was_sent) {
  ReplayOptions options{.ranks = 2, .balancer = engine::no_balancing()};
  options.network = {.latency = 1e-3, .bandwidth = 1e9, .gap = 0, .overhead = 0};
  const Replayed apart = replay(chain(), options);
  // Half a millisecond of work, one of latency, one for the megabyte, two of work.
  EXPECT_NEAR(apart.seconds, 4.5e-3, 0.1e-3);
  options.ranks = 1;
  EXPECT_NEAR(replay(chain(), options).seconds, 3e-3, 0.1e-3);
  options.threads = 2;
  EXPECT_NEAR(replay(chain(), options).seconds, 2.5e-3, 0.1e-3);
}

TEST(Replay, Slower_tasks_take_longer) {
  ReplayOptions options;
  options.slowdown = 3;
  EXPECT_NEAR(replay(chain(), options).seconds, 9e-3, 0.1e-3);
}

TEST(Replay, One_core_takes_the_work_of_all_tasks) {
  const GraphDump dump = recorded(9);
  const Replayed replayed = replay(dump, {});
  EXPECT_GE(replayed.seconds, replayed.work);
  EXPECT_LT(replayed.seconds, 1.1 * replayed.work + 1e-3);
}

TEST(Replay, All_tasks_run_once_in_the_order_of_their_instances_and_after_what_they_wait_for) {
  const GraphDump dump = recorded(20);
  for (const char* balancer : {"none", "stealing", "diffusion", "rotate"}) {
    SCOPED_TRACE(balancer);
    const Replayed replayed = replay(dump, {.ranks = 7, .balancer = engine::balancer_by_name(balancer)});
    ASSERT_EQ(replayed.graph.runs.size(), dump.runs.size());
    // Of each instance: node, round and duration of its runs in their order.
    using Steps = std::vector<std::tuple<dataflow::NodeIndex, std::uint64_t, engine::TimePoint>>;
    std::vector<Steps> was(dump.instances.size()), is(dump.instances.size());
    std::vector<engine::TimePoint> last(dump.instances.size(), -1);
    for (const auto& run : dump.runs)
      was[run.instance].emplace_back(run.node, run.round, run.end - run.begin);
    for (const auto& run : replayed.graph.runs) {
      is[run.instance].emplace_back(run.node, run.round, run.end - run.begin);
      EXPECT_GE(run.begin, last[run.instance]);
      last[run.instance] = run.end;
    }
    EXPECT_EQ(is, was);
    for (const auto& use : replayed.graph.uses) EXPECT_LE(use.time, replayed.graph.runs[use.to].begin);
  }
}

TEST(Replay, No_machine_beats_the_critical_path_nor_the_work_divided_by_its_cores) {
  const GraphDump dump = recorded(64);
  const double path = 1e-9 * static_cast<double>(critical_path(dump).length);
  for (const int ranks : {1, 4, 16, 64, 256}) {
    const Replayed replayed = replay(dump, {.ranks = ranks});
    EXPECT_GE(replayed.seconds, 0.999 * path) << ranks;
    EXPECT_GE(replayed.seconds, 0.999 * replayed.work / ranks) << ranks;
  }
}

TEST(Replay, The_same_replay_gives_the_same_times) {
  const GraphDump dump = recorded(30);
  const Replayed a = replay(dump, {.ranks = 11}), b = replay(dump, {.ranks = 11});
  EXPECT_EQ(a.seconds, b.seconds);
  EXPECT_EQ(a.simulation.packets, b.simulation.packets);
  constexpr auto kMigrate = static_cast<std::size_t>(engine::Traffic::migrate);
  EXPECT_EQ(a.engine.traffic[kMigrate].sent.messages, b.engine.traffic[kMigrate].sent.messages);
}

TEST(Replay, A_thousand_ranks_send_as_many_values_as_one) {
  const GraphDump dump = recorded(256, 2);
  const Replayed replayed = replay(dump, {.ranks = 1024, .balancer = engine::no_balancing()});
  EXPECT_EQ(replayed.engine.ranks.size(), 1024u);
  EXPECT_TRUE(replayed.engine.consistent.pairs);
  std::uint64_t remote = 0;
  for (const auto& use : dump.uses)
    remote += dump.description.edges[use.edge].kind == dataflow::EdgeKind::remote;
  EXPECT_EQ(replayed.engine.traffic[0].sent.messages, remote) << "every subdomain is on a rank of its own";
}

TEST(Replay, An_enlarged_graph_has_so_many_times_the_tasks_and_can_be_replayed) {
  const GraphDump dump = recorded(12);
  const GraphDump large = enlarged(dump, 5);
  EXPECT_EQ(large.instances.size(), 60u);
  EXPECT_EQ(large.runs.size(), 5 * dump.runs.size());
  EXPECT_EQ(large.uses.size(), 5 * dump.uses.size());
  const Replayed replayed = replay(large, {.ranks = 10});
  EXPECT_GT(replayed.work, 3 * replay(dump, {}).work);
}

TEST(Replay, A_planned_graph_is_refused) {
  GraphDump planned = chain();
  planned.runs.clear();
  planned.uses.clear();
  EXPECT_THROW(replay(planned, {}), std::invalid_argument);
}

}  // namespace
}  // namespace weft::graph::replay

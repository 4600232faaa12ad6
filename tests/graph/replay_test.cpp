// Recorded graphs on simulated ranks.
#include "graph/replay/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "graph/dataflow/dump/critical_path.h"
#include "graph/replay/duration_model.h"
#include "graph/replay/replay_plan.h"
#include "tests/support/simulated_run.h"

namespace weft::graph::replay::replay_test {
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

constexpr std::size_t kTets = 0, kChecking = 1, kProcessor = 2;

/// The second task spends three quarters of its time on checks, and has the processor half of it.
GraphDump counted() {
  GraphDump dump = chain();
  dump.counter_names = {"tets", "quality check, seconds", dataflow::kProcessorSeconds};
  dump.runs[1].counters = {5, 1.5e-3, 1e-3};
  dump.runs[1].bytes_received = dump.uses[0].bytes;
  return dump;
}

double seconds_of(const dataflow::DumpedRun& run) { return 1e-9 * static_cast<double>(run.end - run.begin); }

TEST(Replay, What_tasks_have_counted_in_seconds_goes_with_their_time) {
  ReplayOptions options;
  options.slowdown = 3;
  const dataflow::DumpedRun slow = replay(counted(), options).graph.runs.at(1);
  EXPECT_EQ(slow.counters[kTets], 5);
  EXPECT_NEAR(slow.counters[kChecking], 4.5e-3, 1e-6);
  EXPECT_NEAR(slow.counters[kProcessor], 3e-3, 1e-6);

  GraphDump processor = counted();
  take_processor_times(processor);
  EXPECT_NEAR(seconds_of(processor.runs[1]), 1e-3, 1e-9);
  EXPECT_NEAR(processor.runs[1].counters[kChecking], 0.75e-3, 1e-9);
  EXPECT_NEAR(processor.runs[1].counters[kProcessor], 1e-3, 1e-9);

  const GraphDump large = enlarged(counted(), {.grow = 8});
  ASSERT_THAT(large.counter_names,
              ::testing::ElementsAre("quality check, seconds", dataflow::kProcessorSeconds))
      << "how many tets a larger one would have counted is not known";
  EXPECT_NEAR(large.runs[1].counters[0], 0.75 * seconds_of(large.runs[1]), 1e-9);
  EXPECT_EQ(large.runs[1].bytes_received, large.uses[0].bytes);
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
  const GraphDump large = enlarged(dump, {.copies = 5});
  EXPECT_EQ(large.instances.size(), 60u);
  EXPECT_EQ(large.runs.size(), 5 * dump.runs.size());
  EXPECT_EQ(large.uses.size(), 5 * dump.uses.size());
  const Replayed replayed = replay(large, {.ranks = 10});
  EXPECT_GT(replayed.work, 3 * replay(dump, {}).work);
}

dataflow::NodeIndex node_named(const GraphDump& dump, const std::string& name) {
  const auto& nodes = dump.description.nodes;
  const auto found = std::find_if(nodes.begin(), nodes.end(), [&](const auto& n) { return n.name == name; });
  return static_cast<dataflow::NodeIndex>(found - nodes.begin());
}

double seconds_of(const GraphDump& dump) {
  double sum = 0;
  for (const auto& run : dump.runs) sum += 1e-9 * static_cast<double>(run.end - run.begin);
  return sum;
}

std::uint64_t bytes_of(const GraphDump& dump) {
  return std::accumulate(dump.uses.begin(), dump.uses.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& use) { return sum + use.bytes; });
}

TEST(Replay, Times_go_with_the_power_of_the_size_that_was_recorded) {
  const GraphDump dump = recorded(400);
  EXPECT_NEAR(DurationModel(dump).exponent(node_named(dump, "adapt interior")), 1, 0.15);
  GraphDump without = dump;  // nothing is known of sizes
  without.counter_names.clear();
  for (auto& run : without.runs) run.counters.clear();
  EXPECT_EQ(DurationModel(without).exponent(node_named(dump, "propose")), 1);
}

/// 1,000 instances of one node and equal sizes, which take so many milliseconds in turn.
GraphDump taking(const std::vector<int>& milliseconds) {
  GraphDump dump;
  dump.description = {"one", {{"work", dataflow::NodeKind::start}}, {}};
  for (std::uint32_t i = 0; i < 1000; ++i) {
    dump.instances.push_back({i, {engine::Rank(0), i + 1}, engine::Rank(0)});
    dataflow::DumpedRun run;
    run.instance = i, run.end = 1'000'000 * milliseconds[i % milliseconds.size()];
    dump.runs.push_back(run);
  }
  return dump;
}

/// Half of the instances take four times as long as the others; these are by a share `larger` larger.
GraphDump hard_ones(double larger) {
  GraphDump dump = taking({1, 4});
  dump.counter_names = {kSizeCounter};
  std::mt19937_64 random(5);
  std::normal_distribution<double> other_reasons(0, 0.3);
  for (auto& run : dump.runs) {
    const bool hard = run.instance % 2 == 1;
    run.counters = {1000 * (hard ? 1 + larger : 1)};
    run.end = static_cast<engine::TimePoint>(static_cast<double>(run.end) * std::exp(other_reasons(random)));
  }
  return dump;
}

/// What is harder is a little larger, too: that does not make it harder.
TEST(Replay, Sizes_that_hardly_differ_say_nothing_of_what_others_take) {
  EXPECT_NEAR(DurationModel(hard_ones(0.05)).exponent(0), 1, 0.1);
  EXPECT_LT(DurationModel(hard_ones(100)).exponent(0), 0.5) << "a hundredfold size, four times the time";
}

TEST(Replay, What_is_far_beyond_the_usual_is_in_few_of_the_parts) {
  const GraphDump dump = taking({4, 4, 4, 20});
  const DurationModel model(dump);
  const auto takes = [&](std::size_t run, Part part) { return 1e-6 * model.of_part(dump.runs[run], part); };
  EXPECT_NEAR(takes(0, {8, 2, true}), 0.5, 1e-6) << "nothing is hard in it";
  EXPECT_NEAR(takes(3, {8, 2, false}), 1.5, 1e-6) << "three times the usual, in eight";
  EXPECT_NEAR(takes(3, {8, 2, true}), 1.5 + 4, 1e-6);
  EXPECT_NEAR(takes(3, {1, 1, true}), 20, 1e-6);
  // Whatever is hard where: all parts together take what the whole does.
  const GraphDump fine = enlarged(dump, {.split = 8});
  EXPECT_NEAR(seconds_of(fine), seconds_of(dump), 1e-3 * seconds_of(dump));
  std::vector<double> of_instance(dump.instances.size(), 0);
  for (const auto& run : fine.runs) of_instance[run.instance % 1000] += seconds_of(run);
  EXPECT_NEAR(of_instance[2], 0.004, 1e-6);
  EXPECT_NEAR(of_instance[3], 0.020, 1e-6);
  const auto longest = std::ranges::max(fine.runs, {}, [](const auto& run) { return run.end - run.begin; });
  EXPECT_NEAR(seconds_of(longest), 0.0055, 1e-6);
}

TEST(Replay, A_finer_decomposition_of_the_same_mesh_has_about_the_same_work) {
  const GraphDump dump = recorded(64);
  const GraphDump fine = enlarged(dump, {.split = 4});
  EXPECT_EQ(fine.instances.size(), 256u);
  // Of what lies along surfaces there is more.
  const double more = seconds_of(fine) / seconds_of(dump);
  EXPECT_GT(more, 1);
  EXPECT_LT(more, 1.3);
  // Surfaces: so many times as many, each as much smaller to the power 2/3.
  EXPECT_NEAR(static_cast<double>(bytes_of(fine)) / static_cast<double>(bytes_of(dump)), std::cbrt(4), 0.05);
  const double largest = replay(dump, {}).seconds;
  EXPECT_NEAR(replay(fine, {}).seconds / largest, more, 0.05);
  EXPECT_NEAR(seconds_of(enlarged(dump, {.grow = 3})) / seconds_of(dump), 3, 0.45);
  EXPECT_THROW(enlarged(dump, {.grow = 0}), std::invalid_argument);
}

TEST(Replay, Processor_times_take_the_place_of_wall_times) {
  const GraphDump dump = recorded(9);
  GraphDump processor = dump;
  take_processor_times(processor);
  EXPECT_NEAR(seconds_of(processor) / seconds_of(dump), 0.5, 0.001);
  for (const auto& use : processor.uses) {
    EXPECT_GE(use.time, processor.runs[use.from].begin);
    EXPECT_LE(use.time, processor.runs[use.from].end);
  }
  EXPECT_NEAR(replay(processor, {}).work / replay(dump, {}).work, 0.5, 0.001);
  GraphDump none = chain();
  EXPECT_THROW(take_processor_times(none), std::invalid_argument);
}

TEST(Replay, Times_that_are_none_are_refused) {
  for (const double seconds : {-1.0, 1e300, 2 * kMostSeconds}) {
    GraphDump dump = counted();
    dump.runs[1].counters[kProcessor] = seconds;
    EXPECT_THROW(take_processor_times(dump), std::invalid_argument) << seconds;
  }
  for (const double size : {-1.0, 1e300}) {
    GraphDump dump = recorded(9);
    const auto name = std::find(dump.counter_names.begin(), dump.counter_names.end(), kSizeCounter);
    dump.runs[0].counters.assign(dump.counter_names.size(), 0);
    dump.runs[0].counters[static_cast<std::size_t>(name - dump.counter_names.begin())] = size;
    EXPECT_THROW(enlarged(dump, {.split = 2}), std::invalid_argument) << size;
  }
  GraphDump dump = chain();
  dump.runs[1].end = 9'000'000'000'000'000'000;
  EXPECT_THROW(replay(dump, {}), std::invalid_argument);
  EXPECT_THROW(enlarged(dump, {.grow = 2}), std::invalid_argument);
  EXPECT_THROW(replay(chain(), {.slowdown = 1e12}), std::invalid_argument) << "3e9 s";
  EXPECT_THROW(replay(enlarged(chain(), {.grow = 1e12}), {}), std::invalid_argument);
  EXPECT_THROW(enlarged(chain(), {.copies = 100'000'000}), std::invalid_argument);
}

TEST(Replay, An_enlarged_graph_has_the_network_of_its_values_and_the_counts_that_are_known) {
  const GraphDump dump = recorded(12);
  const GraphDump copied = enlarged(dump, {.copies = 3}), grown = enlarged(dump, {.grow = 3});
  const auto values = [](const GraphDump& graph) {
    return std::accumulate(graph.network.begin(), graph.network.end(), std::uint64_t{0},
                           [](std::uint64_t sum, const auto& link) { return sum + link.values; });
  };
  EXPECT_GT(values(dump), 0u);
  EXPECT_EQ(values(copied), 3 * values(dump));
  EXPECT_EQ(values(grown), values(dump));
  EXPECT_EQ(copied.counter_names, dump.counter_names);
  EXPECT_THAT(grown.counter_names,
              ::testing::IsSupersetOf({std::string(kSizeCounter), std::string(dataflow::kProcessorSeconds)}));
  EXPECT_THAT(grown.counter_names, ::testing::Each(::testing::AnyOf(::testing::EndsWith(", seconds"),
                                                                    ::testing::Eq(kSizeCounter))));
  const std::vector<double> was = DurationModel(dump).sizes(), is = DurationModel(grown).sizes();
  EXPECT_NEAR(*std::max_element(is.begin(), is.end()) / *std::max_element(was.begin(), was.end()), 3, 1.5);
  for (const auto& run : grown.runs) EXPECT_LE(run.counters.size(), grown.counter_names.size());
}

/// The first instance sends to the event of the second, whose wake node then asks the third for the second
/// value. By the times of the recording the third was the first.
GraphDump woken() {
  using dataflow::EdgeKind;
  using dataflow::NodeKind;
  using dataflow::RoundStep;
  GraphDump dump;
  dump.description = {"trio",
                      {{"begin", NodeKind::start},
                       {"gather", NodeKind::event},
                       {"wake", NodeKind::wake},
                       {"answer", NodeKind::event}},
                      {{"begin -> gather", EdgeKind::remote, 0, 1, RoundStep::same, "int"},
                       {"gather -> wake", EdgeKind::wake, 1, 2, RoundStep::same, "int"},
                       {"wake -> answer", EdgeKind::remote, 2, 3, RoundStep::same, "int"},
                       {"answer -> gather", EdgeKind::remote, 3, 1, RoundStep::same, "int"}}};
  for (std::uint32_t i = 0; i < 3; ++i)
    dump.instances.push_back({i, {engine::Rank(0), i + 1}, engine::Rank(0)});
  const auto run = [](dataflow::NodeIndex node, dataflow::InstanceIndex instance, engine::TimePoint begin) {
    dataflow::DumpedRun made;
    made.node = node, made.instance = instance, made.begin = begin, made.end = begin + 1'000'000;
    return made;
  };
  dump.runs = {run(0, 0, 0), run(2, 1, 1'000'000), run(3, 2, 2'000'000), run(1, 1, 3'000'000)};
  dump.uses = {{.edge = 2, .from = 1, .to = 2, .time = 1'500'000, .bytes = 8},
               {.edge = 3, .from = 2, .to = 3, .time = 2'000'000, .bytes = 8},
               {.edge = 0, .from = 0, .to = 3, .time = 9'000'000, .bytes = 8}};
  return dump;
}

TEST(Replay, Whichever_value_comes_first_wakes_whatever_the_clocks_said) {
  const Replayed replayed = replay(woken(), {.ranks = 3, .balancer = engine::no_balancing()});
  EXPECT_NEAR(replayed.seconds, 3e-3, 0.1e-3) << "begin, wake, gather; the answer is there by then";
  EXPECT_EQ(replayed.engine.traffic[0].sent.messages, 3u);
}

TEST(Replay, A_graph_that_waits_for_itself_is_refused) {
  GraphDump dump = woken();
  dump.uses.pop_back();  // the answer to its question alone would wake the second
  EXPECT_THROW(replay(dump, {.ranks = 3}), std::invalid_argument);
}

TEST(Replay, A_planned_graph_is_refused) {
  GraphDump planned = chain();
  planned.runs.clear();
  planned.uses.clear();
  EXPECT_THROW(replay(planned, {}), std::invalid_argument);
}

}  // namespace
}  // namespace weft::graph::replay::replay_test

// Dumps of random runs: joined as they happened, acyclic, in time, and what filters and formats make of them.
#include "graph/dataflow/dump/graph_dump.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "engine/json/json.h"
#include "graph/dataflow/dump/critical_path.h"
#include "graph/dataflow/dump/graph_json.h"
#include "graph/dataflow/rank_exchange.h"
#include "tests/graph/rounds_game.h"
#include "tests/support/ranks.h"
#include "tests/support/simulated_run.h"

namespace weft::graph::dataflow::graph_dump_test {
namespace {

using engine::TimePoint;
using weft::testing::SimulationRules;

GraphDump dump_of(const SimulationRules& rules) {
  const weft::testing::SimulatedRun run = weft::testing::simulate(rules);
  return executed_dump(run.graph, run.log, [&](engine::ObjectId object) {
    return weft::testing::subdomain_of_object(rules, object);
  });
}

std::vector<SimulationRules> random_rules() {
  std::vector<SimulationRules> all;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto s = static_cast<std::uint32_t>(seed);
    all.push_back({.subdomains = 2 + 3 * s,
                   .ranks = 1 + s % 4,
                   .workers = 1 + s % 3,
                   .rounds = 1 + s % 4,
                   .migration = s % 2 == 0,
                   .largest_skew = 0,
                   .seed = seed});
  }
  return all;
}

/// The longest chain by recursion over what a run waits for.
class LongestChain {
 public:
  explicit LongestChain(const GraphDump& dump) : dump_(dump), known_(dump.runs.size(), -1) {
    std::map<InstanceIndex, RunIndex> last;
    for (RunIndex r = 0; r < dump.runs.size(); ++r) {
      if (const auto found = last.find(dump.runs[r].instance); found != last.end())
        waits_for_[r].emplace_back(found->second, dump.runs[found->second].end);
      last[dump.runs[r].instance] = r;
    }
    for (const DumpedUse& use : dump.uses) waits_for_[use.to].emplace_back(use.from, use.time);
  }
  TimePoint before(RunIndex run) {
    if (known_[run] >= 0) return known_[run];
    TimePoint longest = 0;
    for (const auto& [from, time] : waits_for_[run])
      longest = std::max(longest, before(from) + time - dump_.runs[from].begin);
    return known_[run] = longest;
  }
  TimePoint longest() {
    TimePoint all = 0;
    for (RunIndex r = 0; r < dump_.runs.size(); ++r)
      all = std::max(all, before(r) + dump_.runs[r].end - dump_.runs[r].begin);
    return all;
  }

 private:
  const GraphDump& dump_;
  std::map<RunIndex, std::vector<std::pair<RunIndex, TimePoint>>> waits_for_;
  std::vector<TimePoint> known_;
};

TEST(GraphDump, JoinsEveryUseWithTheRunsThatItCameFromAndWentTo) {
  for (const SimulationRules& rules : random_rules()) {
    SCOPED_TRACE(rules.seed);
    const weft::testing::SimulatedRun run = weft::testing::simulate(rules);
    const GraphDump dump = dump_of(rules);
    EXPECT_EQ(dump.unmatched_uses, 0u);
    EXPECT_EQ(dump.runs.size(), run.log.runs.size());
    ASSERT_EQ(dump.uses.size(), run.log.uses.size());
    std::map<RunIndex, std::uint64_t> bytes;
    std::map<RunIndex, std::set<RunIndex>> senders;
    for (const DumpedUse& use : dump.uses) {
      const EdgeDescription& edge = dump.description.edges[use.edge];
      const DumpedRun &from = dump.runs[use.from], &to = dump.runs[use.to];
      EXPECT_EQ(from.node, edge.from);
      EXPECT_EQ(to.node, edge.to);
      EXPECT_EQ(to.round, from.round + (edge.step == RoundStep::next ? 1 : 0));
      EXPECT_LE(from.begin, use.time);
      EXPECT_LE(use.time, from.end);
      EXPECT_LE(use.time, to.begin);
      EXPECT_EQ(edge.kind == EdgeKind::local, from.instance == to.instance);
      bytes[use.to] += use.bytes;
      EXPECT_TRUE(senders[use.to].insert(use.from).second);
    }
    for (RunIndex r = 0; r < dump.runs.size(); ++r) {
      EXPECT_EQ(bytes[r], dump.runs[r].bytes_received);
      const InstanceIndex i = dump.runs[r].instance;
      if (dump.description.nodes[dump.runs[r].node].kind == NodeKind::event) {
        EXPECT_EQ(senders[r].size(), run.neighbours[dump.instances[i].number].size());
      }
    }
  }
}

TEST(GraphDump, KnowsInstancesByTheUsersNumbersAndWhereTheyWere) {
  const GraphDump dump = dump_of({.subdomains = 10, .ranks = 3, .workers = 1, .rounds = 2});
  ASSERT_EQ(dump.instances.size(), 10u);
  for (std::size_t i = 0; i < dump.instances.size(); ++i) {
    EXPECT_EQ(dump.instances[i].number, i);
    EXPECT_EQ(dump.instances[i].rank.value, static_cast<std::int32_t>(i * 3 / 10));
  }
}

TEST(GraphDump, CountsUsesWhoseRunsAreMissing) {
  const SimulationRules rules{.subdomains = 6, .rounds = 2};
  weft::testing::SimulatedRun run = weft::testing::simulate(rules);
  const NodeRun lost = run.log.runs[run.log.runs.size() / 2];
  std::erase_if(run.log.runs, [&](const NodeRun& r) {
    return r.node == lost.node && r.instance == lost.instance && r.round == lost.round;
  });
  const GraphDump dump = executed_dump(
      run.graph, run.log, [&](engine::ObjectId o) { return weft::testing::subdomain_of_object(rules, o); });
  EXPECT_GT(dump.unmatched_uses, 0u);
  EXPECT_EQ(dump.uses.size() + dump.unmatched_uses, run.log.uses.size());
}

TEST(CriticalPath, IsTheLongestChainAndNoLongerThanTheRun) {
  for (const SimulationRules& rules : random_rules()) {
    SCOPED_TRACE(rules.seed);
    const GraphDump dump = dump_of(rules);
    EXPECT_EQ(dump.critical_path.length, LongestChain(dump).longest());
    EXPECT_LE(dump.critical_path.length, dump.critical_path.wall);
    EXPECT_GT(dump.critical_path.length, 0);
  }
}

/// Steps follow from each other, and their work adds up.
void expect_chain(const GraphDump& dump) {
  const CriticalPath& path = dump.critical_path;
  TimePoint sum = 0, by_node = 0;
  for (std::size_t i = 0; i < path.steps.size(); ++i) {
    const CriticalPath::Step& step = path.steps[i];
    EXPECT_GE(step.worked, 0);
    sum += step.worked;
    if (i == 0) continue;
    const RunIndex previous = path.steps[i - 1].run;
    if (step.arrived_by) {
      EXPECT_EQ(dump.uses[*step.arrived_by].from, previous);
      EXPECT_EQ(dump.uses[*step.arrived_by].to, step.run);
    } else {
      EXPECT_EQ(dump.runs[previous].instance, dump.runs[step.run].instance);
    }
  }
  for (const PathShare& share : shares_of(dump)) by_node += share.worked;
  EXPECT_EQ(sum, path.length);
  EXPECT_EQ(by_node, path.length);
}

TEST(CriticalPath, IsAChainWhoseWorkAddsUp) {
  for (const SimulationRules& rules : random_rules()) expect_chain(dump_of(rules));
}

TEST(CriticalPath, StaysWithinTheWallTimeWhereClocksDisagree) {
  for (SimulationRules rules : random_rules()) {
    rules.largest_skew = 30'000'000;
    SCOPED_TRACE(rules.seed);
    const GraphDump dump = dump_of(rules);
    EXPECT_EQ(dump.unmatched_uses, 0u);
    EXPECT_LE(dump.critical_path.length, dump.critical_path.wall);
    expect_chain(dump);
  }
}

TEST(CriticalPath, RefusesRunsThatWaitForEachOther) {
  GraphDump dump = dump_of({.subdomains = 4, .rounds = 1});
  const DumpedUse first = dump.uses.front();
  dump.uses.insert(dump.uses.begin(), {first.edge, first.to, first.from, dump.runs[first.to].begin, 1});
  std::stable_sort(dump.uses.begin(), dump.uses.end(),
                   [](const auto& a, const auto& b) { return a.to < b.to; });
  EXPECT_THROW(critical_path(dump), std::invalid_argument);
}

TEST(CriticalPath, OfNothingIsNothing) {
  const GraphDump dump = executed_dump({"none", {}, {}}, {}, [](engine::ObjectId) { return 0; });
  EXPECT_EQ(dump.critical_path.length, 0);
  EXPECT_TRUE(dump.critical_path.steps.empty());
}

TEST(Waits, LieBetweenTheRunBeforeAndTheLastValue) {
  std::size_t found = 0;
  for (const SimulationRules& rules : random_rules()) {
    const GraphDump dump = dump_of(rules);
    std::map<InstanceIndex, TimePoint> waited, worked;
    for (const DumpedRun& run : dump.runs) worked[run.instance] += run.end - run.begin;
    for (const Wait& wait : waits_of(dump)) {
      EXPECT_NE(dump.runs[wait.run].instance, dump.runs[wait.for_run].instance);
      EXPECT_GT(wait.waited, 0);
      waited[dump.runs[wait.run].instance] += wait.waited;
      ++found;
    }
    for (const auto& [instance, time] : waited) EXPECT_LE(time + worked[instance], dump.critical_path.wall);
  }
  EXPECT_GT(found, 0u);
}

TEST(DumpFilter, LeavesWhatFulfilsAllOfIt) {
  for (const SimulationRules& rules : random_rules()) {
    SCOPED_TRACE(rules.seed);
    const GraphDump dump = dump_of(rules);
    const GraphDump left = filtered(dump, {.round = 0, .instance = 1});
    const auto count = std::count_if(dump.runs.begin(), dump.runs.end(), [&](const DumpedRun& run) {
      return run.round == 0 && dump.instances[run.instance].number == 1;
    });
    EXPECT_EQ(left.runs.size(), static_cast<std::size_t>(count));
    for (const DumpedRun& run : left.runs) {
      EXPECT_EQ(run.round, 0u);
      EXPECT_EQ(left.instances[run.instance].number, 1u);
    }
    for (const DumpedUse& use : left.uses) {
      EXPECT_EQ(left.runs[use.from].node, dump.description.edges[use.edge].from);
      EXPECT_EQ(left.runs[use.to].node, dump.description.edges[use.edge].to);
    }
  }
}

TEST(DumpFilter, LeavesTheCriticalPathWhole) {
  const GraphDump dump = dump_of({.subdomains = 12, .ranks = 3, .rounds = 3, .seed = 5});
  const GraphDump left = filtered(dump, {.critical_path_only = true});
  ASSERT_EQ(left.runs.size(), dump.critical_path.steps.size());
  ASSERT_EQ(left.critical_path.steps.size(), dump.critical_path.steps.size());
  EXPECT_EQ(left.critical_path.length, dump.critical_path.length);
  expect_chain(left);
}

TEST(DumpFilter, RefusesWhatTheGraphHasNot) {
  const GraphDump dump = dump_of({.subdomains = 3, .rounds = 1});
  EXPECT_THROW(filtered(dump, {.instance = 3}), std::invalid_argument);
  const GraphDump plan = planned_dump(dump.description, dump.instances, {{0, 1}, {1, 0}});
  EXPECT_THROW(filtered(plan, {.round = 0}), std::invalid_argument);
  EXPECT_THROW(filtered(plan, {.critical_path_only = true}), std::invalid_argument);
  EXPECT_THROW(planned_dump(dump.description, dump.instances, {{0, 3}}), std::out_of_range);
}

TEST(PlannedDump, HasEveryRemoteEdgeBetweenNeighbours) {
  const GraphDump dump = dump_of({.subdomains = 5, .rounds = 1});
  const GraphDump plan = planned_dump(dump.description, dump.instances, {{0, 1}, {1, 0}, {4, 1}});
  const auto remote = std::count_if(plan.description.edges.begin(), plan.description.edges.end(),
                                    [](const EdgeDescription& e) { return e.kind == EdgeKind::remote; });
  EXPECT_EQ(plan.network.size(), static_cast<std::size_t>(3 * remote));
  EXPECT_FALSE(plan.executed());
  EXPECT_EQ(filtered(plan, {.instance = 4}).network.size(), static_cast<std::size_t>(remote));
}

TEST(GraphJson, ComesBackAsItWas) {
  for (const SimulationRules& rules : random_rules()) {
    const GraphDump dump = dump_of(rules);
    const nlohmann::ordered_json json = json_of(dump);
    const GraphDump back = dump_from_json(nlohmann::ordered_json::parse(json.dump()));
    EXPECT_EQ(json_of(back).dump(), json.dump());
    EXPECT_EQ(critical_path(back).length, dump.critical_path.length);
  }
  const GraphDump some = dump_of({.subdomains = 5, .rounds = 1});
  const nlohmann::ordered_json plan = json_of(planned_dump(some.description, some.instances, {{0, 1}}));
  EXPECT_EQ(json_of(dump_from_json(plan)).dump(), plan.dump());
}

/// `change` makes the document one that is refused, with a message that names the place.
void expect_refused(const nlohmann::ordered_json& good, const char* pointer, nlohmann::ordered_json value,
                    const std::string& says) {
  nlohmann::ordered_json bad = good;
  bad[nlohmann::ordered_json::json_pointer(pointer)] = std::move(value);
  try {
    dump_from_json(bad);
    ADD_FAILURE() << pointer << " was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(says));
  }
}

TEST(GraphJson, RefusesWhatIsNoDump) {
  const nlohmann::ordered_json good = json_of(dump_of({.subdomains = 3, .rounds = 1}));
  expect_refused(good, "/schema", "weft-graph-2", "weft-graph-2");
  expect_refused(good, "/graph/nodes/0/kind", "strange", "graph.nodes[0].kind");
  expect_refused(good, "/graph/edges/0/to", 99, "graph.edges[0].to");
  expect_refused(good, "/instances/0/object", {1}, "instances[0].object");
  expect_refused(good, "/runs/node/0", 99, "runs.node");
  expect_refused(good, "/runs/node/0", -1, "runs.node[0]");
  expect_refused(good, "/runs/rank", {0}, "runs.rank");
  expect_refused(good, "/runs/counters/tets sent/0", "many", "runs.counters.tets sent[0]");
  expect_refused(good, "/uses/to/0", 1000000, "uses.to");
  expect_refused(good, "/uses/time_ns/0", 1e15, "uses.time_ns");
  expect_refused(good, "/uses/time_ns/0", 1'000'000'000'000'000, "uses.time_ns[0]");
  expect_refused(good, "/critical_path/uses", nlohmann::ordered_json::array(), "critical_path.uses");
  expect_refused(good, "/network/edge", nullptr, "network.edge");
  expect_refused(good, "/graph", nlohmann::ordered_json::object(), "graph.name");
}

/// What the engine logs, with instances that move, obeys the same rules.
TEST(GraphDump, OfARunOfTheEngineIsWhole) {
  using weft::testing::Player;
  for (const bool moving : {false, true}) {
    ExecutionLog together;
    std::mutex mutex;
    constexpr int kRanks = 3;
    weft::testing::on_ranks(kRanks, [&](engine::Transport& transport) {
      engine::Registry registry;
      register_blueprint<Player>(registry);
      engine::Runtime runtime(transport, registry,
                              {.balancer = moving ? engine::rotate() : engine::no_balancing()});
      weft::testing::GameRules rules{.players = 9, .ranks = kRanks, .rounds = 6};
      runtime.run(
          [&](engine::Context& context) { weft::testing::start_game(Recording::on, context, rules); });
      const std::lock_guard lock(mutex);
      together.append(log_of<Player>(runtime));
    });
    const GraphDump dump =
        executed_dump(blueprint_of<Player>().description(), together, [](engine::ObjectId o) {
          return std::uint64_t{o.number} * kRanks + static_cast<std::uint64_t>(o.home.value);
        });
    EXPECT_EQ(dump.unmatched_uses, 0u);
    EXPECT_EQ(dump.uses.size(), together.uses.size());
    EXPECT_LE(dump.critical_path.length, dump.critical_path.wall);
    EXPECT_EQ(dump.critical_path.length, LongestChain(dump).longest());
    for (const DumpedUse& use : dump.uses) EXPECT_LE(use.time, dump.runs[use.to].begin);
    expect_chain(dump);
  }
}

}  // namespace
}  // namespace weft::graph::dataflow::graph_dump_test

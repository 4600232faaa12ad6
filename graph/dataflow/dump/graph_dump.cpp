// Joins what the log has apart, and filters.
#include "graph/dataflow/dump/graph_dump.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <unordered_map>

#include "graph/dataflow/dump/critical_path.h"

namespace weft::graph::dataflow {
namespace {

using engine::TimePoint;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Numbers the log's instances, ascending by the users' numbers.
class InstanceTable {
 public:
  InstanceTable(const ExecutionLog& log, const NumberOf& number_of) {
    for (const NodeRun& run : log.runs) {
      if (index_.try_emplace(run.instance, 0).second)
        instances_.push_back({number_of(run.instance), run.instance, {}});
    }
    std::sort(instances_.begin(), instances_.end(), [](const DumpedInstance& a, const DumpedInstance& b) {
      return std::tie(a.number, a.object) < std::tie(b.number, b.object);
    });
    for (std::uint32_t i = 0; i < instances_.size(); ++i) index_[instances_[i].object] = i;
  }

  InstanceIndex operator[](engine::ObjectId object) const {
    const auto found = index_.find(object);
    return found == index_.end() ? kNone : found->second;
  }
  std::vector<DumpedInstance> take() { return std::move(instances_); }

 private:
  std::vector<DumpedInstance> instances_;
  std::unordered_map<engine::ObjectId, InstanceIndex> index_;
};

/// The order of runs in a dump. What an instance did stays in the order of its log, also where it moved
/// between ranks whose clocks disagree by more than its rest.
std::vector<std::uint32_t> order_of(const ExecutionLog& log) {
  std::vector<TimePoint> key(log.runs.size());
  std::unordered_map<engine::ObjectId, TimePoint> latest;
  for (std::size_t i = 0; i < key.size(); ++i) {
    TimePoint& time = latest.try_emplace(log.runs[i].instance, log.runs[i].begin).first->second;
    key[i] = time = std::max(time, log.runs[i].begin);
  }
  std::vector<std::uint32_t> order(key.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
  return order;
}

std::vector<double> counters_of(const ExecutionLog& log, const NodeRun& run) {
  std::vector<double> values;
  for (std::uint32_t i = run.first_counter; i < run.first_counter + run.counters; ++i) {
    const Counter& counter = log.counters[i];
    if (values.size() <= counter.name) values.resize(counter.name + 1);
    values[counter.name] += counter.value;
  }
  return values;
}

/// Finds the two runs of each use; see executed_dump().
class UseJoiner {
 public:
  UseJoiner(const GraphDump& dump, const InstanceTable& instances) : dump_(dump), instances_(instances) {
    for (RunIndex r = 0; r < dump.runs.size(); ++r) {
      const DumpedRun& run = dump.runs[r];
      senders_[{run.instance, run.node}].runs.push_back(r);
      targets_[{run.instance, run.node, run.round}].push_back(r);
    }
    taken_.resize(dump.runs.size());
  }

  /// Uses of one instance must come in the order in which they happened. `time`: on the dump's clock.
  std::optional<DumpedUse> join(const EdgeUse& use, TimePoint time) {
    const EdgeDescription& edge = dump_.description.edges.at(use.edge);
    const RunIndex from = sender(use, edge.from, time);
    if (from == kNone) return std::nullopt;
    const RunIndex to = target(use, edge, from);
    if (to == kNone) return std::nullopt;
    return DumpedUse{use.edge, from, to, time, use.bytes};
  }

 private:
  struct Sender {
    std::vector<RunIndex> runs;
    std::size_t next = 0;  ///< those before had ended when the last use was sent
  };

  RunIndex sender(const EdgeUse& use, NodeIndex node, TimePoint time) {
    const auto found = senders_.find({instances_[use.from], node});
    if (found == senders_.end()) return kNone;
    Sender& sender = found->second;
    for (std::size_t i = sender.next; i < sender.runs.size(); ++i) {
      const DumpedRun& run = dump_.runs[sender.runs[i]];
      if (run.rank != use.rank || time < run.begin || run.end < time) continue;
      sender.next = i;
      return sender.runs[i];
    }
    return kNone;
  }

  RunIndex target(const EdgeUse& use, const EdgeDescription& edge, RunIndex from) {
    const auto found = targets_.find({instances_[use.to], edge.to, use.round});
    if (found == targets_.end()) return kNone;
    if (edge.kind == EdgeKind::remote) return found->second.front();  // an event runs once in a round
    for (const RunIndex run : found->second) {
      if (run <= from || taken_[run]) continue;
      taken_[run] = true;
      return run;
    }
    return kNone;
  }

  const GraphDump& dump_;
  const InstanceTable& instances_;
  std::map<std::pair<InstanceIndex, NodeIndex>, Sender> senders_;
  std::map<std::tuple<InstanceIndex, NodeIndex, std::uint64_t>, std::vector<RunIndex>> targets_;
  std::vector<bool> taken_;
};

void add_runs(const ExecutionLog& log, const InstanceTable& instances, TimePoint start, GraphDump& dump) {
  for (const std::uint32_t i : order_of(log)) {
    const NodeRun& run = log.runs[i];
    if (run.node >= dump.description.nodes.size())
      throw std::out_of_range("a run is of no node of the graph " + dump.description.name);
    dump.runs.push_back({run.node, instances[run.instance], run.round, run.rank, run.begin - start,
                         run.end - start, run.bytes_received, counters_of(log, run)});
  }
}

void add_uses(const ExecutionLog& log, const InstanceTable& instances, TimePoint start, GraphDump& dump) {
  UseJoiner joiner(dump, instances);
  std::vector<DumpedUse> uses;
  for (const EdgeUse& use : log.uses) {
    if (const auto joined = joiner.join(use, use.time - start))
      uses.push_back(*joined);
    else
      ++dump.unmatched_uses;
  }
  std::stable_sort(uses.begin(), uses.end(), [](const DumpedUse& a, const DumpedUse& b) {
    return std::tie(a.to, a.time) < std::tie(b.to, b.time);
  });
  dump.uses = std::move(uses);
}

/// Instances move: each is said to be where it has spent most time.
void set_ranks(GraphDump& dump) {
  std::vector<std::map<engine::Rank, TimePoint>> spent(dump.instances.size());
  for (const DumpedRun& run : dump.runs) spent[run.instance][run.rank] += run.end - run.begin + 1;
  for (std::size_t i = 0; i < spent.size(); ++i) {
    const auto most = std::max_element(spent[i].begin(), spent[i].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != spent[i].end()) dump.instances[i].rank = most->first;
  }
}

InstanceIndex instance_numbered(const GraphDump& dump, std::uint64_t number) {
  for (InstanceIndex i = 0; i < dump.instances.size(); ++i)
    if (dump.instances[i].number == number) return i;
  throw std::invalid_argument("the graph has no " + dump.description.name + " " + std::to_string(number));
}

/// Leaves the runs with `keep`, the uses between them, and the critical path's steps among them.
void keep_runs(const std::vector<bool>& keep, GraphDump& dump) {
  std::vector<RunIndex> old_to_new(dump.runs.size(), kNone);
  std::vector<DumpedRun> runs;
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    if (!keep[r]) continue;
    old_to_new[r] = static_cast<RunIndex>(runs.size());
    runs.push_back(std::move(dump.runs[r]));
  }
  std::vector<std::uint32_t> use_to_new(dump.uses.size(), kNone);
  std::vector<DumpedUse> uses;
  for (std::uint32_t u = 0; u < dump.uses.size(); ++u) {
    DumpedUse use = dump.uses[u];
    if (!keep[use.from] || !keep[use.to]) continue;
    use.from = old_to_new[use.from], use.to = old_to_new[use.to];
    use_to_new[u] = static_cast<std::uint32_t>(uses.size());
    uses.push_back(use);
  }
  std::vector<CriticalPath::Step> steps;
  for (CriticalPath::Step step : dump.critical_path.steps) {
    if (!keep[step.run]) continue;
    step.run = old_to_new[step.run];
    if (step.arrived_by && use_to_new[*step.arrived_by] == kNone) step.arrived_by.reset();
    if (step.arrived_by) step.arrived_by = use_to_new[*step.arrived_by];
    steps.push_back(step);
  }
  dump.runs = std::move(runs), dump.uses = std::move(uses), dump.critical_path.steps = std::move(steps);
}

void keep_links_of(InstanceIndex instance, GraphDump& dump) {
  std::erase_if(dump.network, [&](const NetworkLink& l) { return l.from != instance && l.to != instance; });
}

}  // namespace

GraphDump planned_dump(GraphDescription description, std::vector<DumpedInstance> instances,
                       const std::vector<std::pair<InstanceIndex, InstanceIndex>>& neighbours) {
  GraphDump dump;
  dump.description = std::move(description);
  dump.instances = std::move(instances);
  for (const auto& [from, to] : neighbours) {
    if (from >= dump.instances.size() || to >= dump.instances.size())
      throw std::out_of_range("a neighbour is no instance of the graph " + dump.description.name);
    for (EdgeIndex e = 0; e < dump.description.edges.size(); ++e)
      if (dump.description.edges[e].kind == EdgeKind::remote) dump.network.push_back({from, to, e, 0, 0});
  }
  std::sort(dump.network.begin(), dump.network.end(), [](const NetworkLink& a, const NetworkLink& b) {
    return std::tie(a.from, a.to, a.edge) < std::tie(b.from, b.to, b.edge);
  });
  return dump;
}

GraphDump executed_dump(GraphDescription description, const ExecutionLog& log, const NumberOf& number_of) {
  GraphDump dump;
  dump.description = std::move(description);
  dump.counter_names = log.counter_names;
  InstanceTable instances(log, number_of);
  const TimePoint start = start_of(log);
  add_runs(log, instances, start, dump);
  add_uses(log, instances, start, dump);
  dump.instances = instances.take();
  set_ranks(dump);
  dump.network = network_of(dump);
  dump.critical_path = critical_path(dump);
  return dump;
}

TimePoint start_of(const ExecutionLog& log) {
  if (log.runs.empty()) return 0;
  return std::ranges::min(log.runs, {}, &NodeRun::begin).begin;
}

GraphDump filtered(const GraphDump& dump, const DumpFilter& filter) {
  if (!dump.executed() && (filter.round || filter.critical_path_only))
    throw std::invalid_argument("a planned graph has no rounds and no critical path");
  GraphDump left = dump;
  std::vector<bool> keep(dump.runs.size(), true);
  const std::vector<bool> critical = on_critical_path(dump);
  const InstanceIndex only = filter.instance ? instance_numbered(dump, *filter.instance) : kNone;
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    const DumpedRun& run = dump.runs[r];
    keep[r] = (!filter.round || run.round == *filter.round) && (only == kNone || run.instance == only) &&
              (!filter.critical_path_only || critical[r]);
  }
  keep_runs(keep, left);
  if (filter.round || filter.critical_path_only) left.network = network_of(left);
  if (only != kNone) {
    if (!filter.round && !filter.critical_path_only) left.network = dump.network;
    keep_links_of(only, left);
  }
  return left;
}

std::vector<bool> on_critical_path(const GraphDump& dump) {
  std::vector<bool> critical(dump.runs.size(), false);
  for (const CriticalPath::Step& step : dump.critical_path.steps) critical[step.run] = true;
  return critical;
}

std::vector<NetworkLink> network_of(const GraphDump& dump) {
  std::map<std::tuple<InstanceIndex, InstanceIndex, EdgeIndex>, NetworkLink> links;
  for (const DumpedUse& use : dump.uses) {
    if (dump.description.edges[use.edge].kind != EdgeKind::remote) continue;
    const InstanceIndex from = dump.runs[use.from].instance, to = dump.runs[use.to].instance;
    NetworkLink& link =
        links.try_emplace({from, to, use.edge}, NetworkLink{from, to, use.edge, 0, 0}).first->second;
    ++link.values;
    link.bytes += use.bytes;
  }
  std::vector<NetworkLink> network;
  for (const auto& [key, link] : links) network.push_back(link);
  return network;
}

}  // namespace weft::graph::dataflow

// One function for each way to collapse a planned or executed graph.
#include "graph/dataflow/dump/graph_drawing.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "engine/base/text.h"

namespace weft::graph::dataflow {
namespace {

using engine::TimePoint;

double seconds(TimePoint nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

std::string seconds_text(TimePoint nanoseconds) {
  const double s = seconds(nanoseconds);
  if (s >= 0.0995) return engine::significant(s, 3) + " s";
  if (s >= 99.5e-6) return engine::significant(1e3 * s, 3) + " ms";
  return engine::significant(1e6 * s, 3) + " us";
}

std::string bytes_text(std::uint64_t bytes) {
  const auto b = static_cast<double>(bytes);
  if (bytes < 1000) return std::to_string(bytes) + " B";
  if (b < 1e6) return engine::significant(1e-3 * b, 3) + " kB";
  return engine::significant(1e-6 * b, 4) + " MB";
}

std::int64_t integer(std::uint64_t value) { return static_cast<std::int64_t>(value); }

DrawnEdgeKind drawn(EdgeKind kind) {
  return kind == EdgeKind::local    ? DrawnEdgeKind::local
         : kind == EdgeKind::remote ? DrawnEdgeKind::remote
                                    : DrawnEdgeKind::wake;
}

/// Clusters by what they stand for, in ascending order.
template <class Key>
class Clusters {
 public:
  Clusters(const std::set<Key>& keys, const std::string& word, Drawing& drawing) {
    for (const Key& key : keys) {
      index_[key] = drawing.clusters.size();
      drawing.clusters.push_back(word + " " + std::to_string(key));
    }
  }
  std::size_t operator[](const Key& key) const { return index_.at(key); }

 private:
  std::map<Key, std::size_t> index_;
};

void set_weights(const std::vector<TimePoint>& spent, Drawing& drawing) {
  TimePoint most = 1;
  for (const TimePoint t : spent) most = std::max(most, t);
  for (std::size_t v = 0; v < spent.size(); ++v)
    drawing.vertices[v].weight = static_cast<double>(spent[v]) / static_cast<double>(most);
}

/// The steps of the critical path that no use shows.
std::vector<std::pair<RunIndex, RunIndex>> order_steps(const CriticalPath& path) {
  std::vector<std::pair<RunIndex, RunIndex>> steps;
  for (std::size_t i = 1; i < path.steps.size(); ++i)
    if (!path.steps[i].arrived_by) steps.emplace_back(path.steps[i - 1].run, path.steps[i].run);
  return steps;
}

std::vector<bool> critical_uses(const GraphDump& dump) {
  std::vector<bool> critical(dump.uses.size(), false);
  for (const CriticalPath::Step& step : dump.critical_path.steps)
    if (step.arrived_by) critical[*step.arrived_by] = true;
  return critical;
}

// --- Executed, each run

DrawnVertex vertex_of_run(const GraphDump& dump, RunIndex r, const std::string& instance_word) {
  const DumpedRun& run = dump.runs[r];
  const NodeDescription& node = dump.description.nodes[run.node];
  const std::uint64_t number = dump.instances[run.instance].number;
  DrawnVertex vertex;
  vertex.id = "run " + std::to_string(r);
  vertex.label = {node.name,
                  instance_word + " " + std::to_string(number) + ", round " + std::to_string(run.round),
                  seconds_text(run.end - run.begin)};
  vertex.node = run.node;
  vertex.attributes = {{"node", node.name},
                       {"kind", std::string(name_of(node.kind))},
                       {instance_word, integer(number)},
                       {"rank", std::int64_t{run.rank.value}},
                       {"round", integer(run.round)},
                       {"begin", seconds(run.begin)},
                       {"seconds", seconds(run.end - run.begin)},
                       {"bytes_received", integer(run.bytes_received)}};
  for (std::size_t c = 0; c < dump.counter_names.size(); ++c)
    vertex.attributes.emplace_back(dump.counter_names[c], c < run.counters.size() ? run.counters[c] : 0.0);
  return vertex;
}

Drawing runs_drawing(const GraphDump& dump, const std::string& instance_word) {
  Drawing drawing{dump.description.name, {}, {}, {}};
  std::set<std::int32_t> ranks;
  for (const DumpedRun& run : dump.runs) ranks.insert(run.rank.value);
  const Clusters<std::int32_t> clusters(ranks, "rank", drawing);
  const std::vector<bool> critical = on_critical_path(dump);
  std::vector<TimePoint> spent;
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    drawing.vertices.push_back(vertex_of_run(dump, r, instance_word));
    drawing.vertices.back().cluster = clusters[dump.runs[r].rank.value];
    drawing.vertices.back().critical = critical[r];
    spent.push_back(dump.runs[r].end - dump.runs[r].begin);
  }
  set_weights(spent, drawing);
  const std::vector<bool> critical_use = critical_uses(dump);
  for (std::size_t u = 0; u < dump.uses.size(); ++u) {
    const DumpedUse& use = dump.uses[u];
    const EdgeDescription& edge = dump.description.edges[use.edge];
    const bool remote = edge.kind == EdgeKind::remote;
    drawing.edges.push_back(
        {use.from,
         use.to,
         drawn(edge.kind),
         remote ? bytes_text(use.bytes) : "",
         critical_use[u],
         {{"edge", edge.name}, {"time", seconds(use.time)}, {"bytes", integer(use.bytes)}}});
  }
  for (const auto& [from, to] : order_steps(dump.critical_path)) {
    drawing.edges.push_back({from,
                             to,
                             DrawnEdgeKind::order,
                             "",
                             true,
                             {{"edge", std::string("next in the instance")},
                              {"time", seconds(dump.runs[from].end)},
                              {"bytes", std::int64_t{0}}}});
  }
  return drawing;
}

// --- Groups of runs

struct Group {
  std::uint64_t runs = 0;
  TimePoint spent = 0, longest = 0;
  bool critical = false;

  void add(const DumpedRun& run, bool is_critical) {
    ++runs;
    spent += run.end - run.begin;
    longest = std::max(longest, run.end - run.begin);
    critical |= is_critical;
  }
  void describe(DrawnVertex& vertex) const {
    vertex.critical = critical;
    vertex.label.push_back(std::to_string(runs) + (runs == 1 ? " run, " : " runs, ") + seconds_text(spent));
    vertex.attributes.emplace_back("runs", integer(runs));
    vertex.attributes.emplace_back("seconds", seconds(spent));
    vertex.attributes.emplace_back("longest", seconds(longest));
  }
};

/// Adds up uses between groups; `group_of`: the vertex of each run.
void add_grouped_edges(const GraphDump& dump, const std::vector<std::size_t>& group_of, Drawing& drawing) {
  struct Sum {
    std::uint64_t values = 0, bytes = 0;
    bool critical = false;
  };
  std::map<std::tuple<std::size_t, std::size_t, EdgeIndex>, Sum> sums;
  const std::vector<bool> critical = critical_uses(dump);
  for (std::size_t u = 0; u < dump.uses.size(); ++u) {
    const DumpedUse& use = dump.uses[u];
    const std::size_t from = group_of[use.from], to = group_of[use.to];
    const bool local = dump.description.edges[use.edge].kind != EdgeKind::remote;
    if (from == to && local) continue;
    Sum& sum = sums[{from, to, use.edge}];
    ++sum.values, sum.bytes += use.bytes, sum.critical |= critical[u];
  }
  for (const auto& [key, sum] : sums) {
    const auto& [from, to, index] = key;
    const EdgeDescription& edge = dump.description.edges[index];
    const bool remote = edge.kind == EdgeKind::remote;
    drawing.edges.push_back(
        {from,
         to,
         drawn(edge.kind),
         remote ? bytes_text(sum.bytes) : "",
         sum.critical,
         {{"edge", edge.name}, {"values", integer(sum.values)}, {"bytes", integer(sum.bytes)}}});
  }
}

Drawing rounds_drawing(const GraphDump& dump) {
  Drawing drawing{dump.description.name, {}, {}, {}};
  std::map<std::pair<std::uint64_t, NodeIndex>, Group> groups;
  const std::vector<bool> critical = on_critical_path(dump);
  std::set<std::uint64_t> rounds;
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    groups[{dump.runs[r].round, dump.runs[r].node}].add(dump.runs[r], critical[r]);
    rounds.insert(dump.runs[r].round);
  }
  const Clusters<std::uint64_t> clusters(rounds, "round", drawing);
  std::map<std::pair<std::uint64_t, NodeIndex>, std::size_t> vertex_of;
  std::vector<TimePoint> spent;
  for (const auto& [key, group] : groups) {
    vertex_of[key] = drawing.vertices.size();
    DrawnVertex vertex;
    const std::string& name = dump.description.nodes[key.second].name;
    vertex.id = "round " + std::to_string(key.first) + " node " + std::to_string(key.second);
    vertex.label = {name};
    vertex.node = key.second;
    vertex.cluster = clusters[key.first];
    vertex.attributes = {{"node", name}, {"round", integer(key.first)}};
    group.describe(vertex);
    drawing.vertices.push_back(std::move(vertex));
    spent.push_back(group.spent);
  }
  set_weights(spent, drawing);
  std::vector<std::size_t> group_of;
  for (const DumpedRun& run : dump.runs) group_of.push_back(vertex_of.at({run.round, run.node}));
  add_grouped_edges(dump, group_of, drawing);
  return drawing;
}

/// The instances that have a run or a link, with their vertices.
std::map<InstanceIndex, std::size_t> add_instances(const GraphDump& dump, const std::string& instance_word,
                                                   Drawing& drawing) {
  std::map<InstanceIndex, Group> groups;
  for (const NetworkLink& link : dump.network) groups[link.from], groups[link.to];
  if (!dump.executed() && dump.network.empty())
    for (InstanceIndex i = 0; i < dump.instances.size(); ++i) groups[i];
  const std::vector<bool> critical = on_critical_path(dump);
  for (RunIndex r = 0; r < dump.runs.size(); ++r)
    groups[dump.runs[r].instance].add(dump.runs[r], critical[r]);
  std::set<std::int32_t> ranks;
  for (const auto& [i, group] : groups) ranks.insert(dump.instances[i].rank.value);
  const Clusters<std::int32_t> clusters(ranks, "rank", drawing);
  std::map<InstanceIndex, std::size_t> vertex_of;
  std::vector<TimePoint> spent;
  for (const auto& [i, group] : groups) {
    const DumpedInstance& instance = dump.instances[i];
    vertex_of[i] = drawing.vertices.size();
    DrawnVertex vertex;
    vertex.id = "instance " + std::to_string(i);
    vertex.label = {instance_word + " " + std::to_string(instance.number)};
    vertex.cluster = clusters[instance.rank.value];
    vertex.attributes = {{instance_word, integer(instance.number)},
                         {"rank", std::int64_t{instance.rank.value}}};
    if (dump.executed()) group.describe(vertex);
    drawing.vertices.push_back(std::move(vertex));
    spent.push_back(group.spent);
  }
  set_weights(spent, drawing);
  return vertex_of;
}

Drawing instances_drawing(const GraphDump& dump, const std::string& instance_word) {
  Drawing drawing{dump.description.name, {}, {}, {}, true};
  const auto vertex_of = add_instances(dump, instance_word, drawing);
  if (dump.executed()) {
    std::vector<std::size_t> group_of;
    for (const DumpedRun& run : dump.runs) group_of.push_back(vertex_of.at(run.instance));
    add_grouped_edges(dump, group_of, drawing);
    return drawing;
  }
  for (const NetworkLink& link : dump.network) {
    const EdgeDescription& edge = dump.description.edges[link.edge];
    drawing.edges.push_back({vertex_of.at(link.from),
                             vertex_of.at(link.to),
                             DrawnEdgeKind::remote,
                             dump.description.nodes[edge.to].name,
                             false,
                             {{"edge", edge.name}, {"value_type", edge.value_type}}});
  }
  return drawing;
}

struct Exchange {
  std::uint64_t values = 0, bytes = 0;
  bool critical = false;

  void add(const DrawnEdge& edge) {
    critical |= edge.critical;
    for (const auto& [name, value] : edge.attributes) {
      if (name == "values") values += static_cast<std::uint64_t>(std::get<std::int64_t>(value));
      if (name == "bytes") bytes += static_cast<std::uint64_t>(std::get<std::int64_t>(value));
    }
  }
};

// --- Planned

void add_blueprint(const GraphDescription& description, const std::string& prefix, Drawing& drawing) {
  const std::size_t first = drawing.vertices.size();
  for (NodeIndex n = 0; n < description.nodes.size(); ++n) {
    const NodeDescription& node = description.nodes[n];
    DrawnVertex vertex;
    vertex.id = prefix + "node " + std::to_string(n);
    vertex.label = {node.name};
    vertex.node = n;
    vertex.attributes = {{"node", node.name}, {"kind", std::string(name_of(node.kind))}};
    drawing.vertices.push_back(std::move(vertex));
  }
  for (const EdgeDescription& edge : description.edges) {
    if (edge.kind == EdgeKind::remote && !prefix.empty()) continue;  // the network shows them
    const bool next = edge.kind == EdgeKind::local && edge.step == RoundStep::next;
    drawing.edges.push_back({first + edge.from,
                             first + edge.to,
                             drawn(edge.kind),
                             next ? "next round" : "",
                             false,
                             {{"edge", edge.name}, {"value_type", edge.value_type}}});
  }
}

Drawing planned_drawing(const GraphDump& dump, const std::string& instance_word) {
  Drawing drawing{dump.description.name, {}, {}, {}};
  std::set<InstanceIndex> shown;
  for (const NetworkLink& link : dump.network) shown.insert(link.from), shown.insert(link.to);
  if (dump.network.empty())
    for (InstanceIndex i = 0; i < dump.instances.size(); ++i) shown.insert(i);
  std::map<InstanceIndex, std::size_t> first;
  for (const InstanceIndex i : shown) {
    first[i] = drawing.vertices.size();
    add_blueprint(dump.description, "instance " + std::to_string(i) + " ", drawing);
    for (std::size_t v = first[i]; v < drawing.vertices.size(); ++v) {
      drawing.vertices[v].cluster = drawing.clusters.size();
      drawing.vertices[v].attributes.emplace_back(instance_word, integer(dump.instances[i].number));
      drawing.vertices[v].attributes.emplace_back("rank", std::int64_t{dump.instances[i].rank.value});
    }
    drawing.clusters.push_back(instance_word + " " + std::to_string(dump.instances[i].number) + ", rank " +
                               std::to_string(dump.instances[i].rank.value));
  }
  for (const NetworkLink& link : dump.network) {
    const EdgeDescription& edge = dump.description.edges[link.edge];
    drawing.edges.push_back({first.at(link.from) + edge.from,
                             first.at(link.to) + edge.to,
                             DrawnEdgeKind::remote,
                             "",
                             false,
                             {{"edge", edge.name}, {"value_type", edge.value_type}}});
  }
  return drawing;
}

}  // namespace

const char* name_of(DrawnEdgeKind kind) {
  switch (kind) {
    case DrawnEdgeKind::local:
      return "local";
    case DrawnEdgeKind::remote:
      return "remote";
    case DrawnEdgeKind::wake:
      return "wake";
    case DrawnEdgeKind::order:
      return "order";
  }
  return "";
}

Drawing joined_edges(const Drawing& network) {
  std::map<std::pair<std::size_t, std::size_t>, Exchange> exchanges;
  for (const DrawnEdge& edge : network.edges)
    if (edge.from != edge.to) exchanges[std::minmax(edge.from, edge.to)].add(edge);
  Drawing joined = network;
  joined.edges.clear();
  for (const auto& [pair, exchange] : exchanges) {
    joined.edges.push_back({pair.first,
                            pair.second,
                            DrawnEdgeKind::remote,
                            exchange.values > 0 ? bytes_text(exchange.bytes) : "",
                            exchange.critical,
                            {{"values", integer(exchange.values)}, {"bytes", integer(exchange.bytes)}}});
  }
  return joined;
}

Drawing drawing_of(const GraphDump& dump, Collapse collapse, const std::string& instance_word) {
  if (collapse == Collapse::instances) return instances_drawing(dump, instance_word);
  if (collapse == Collapse::rounds)
    return dump.executed() ? rounds_drawing(dump) : drawing_of(dump.description);
  return dump.executed() ? runs_drawing(dump, instance_word) : planned_drawing(dump, instance_word);
}

Drawing drawing_of(const GraphDescription& description) {
  Drawing drawing{description.name, {}, {}, {}};
  add_blueprint(description, "", drawing);
  return drawing;
}

}  // namespace weft::graph::dataflow

// Runs and uses are written by columns: a third of the size of rows with names, and what plotting wants.
#include "graph/dataflow/dump/graph_json.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "engine/json/json.h"
#include "graph/dataflow/dump/critical_path.h"

namespace weft::graph::dataflow {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "weft-graph-1";

template <class Row, class Value>
Json column(const std::vector<Row>& rows, const Value& value) {
  Json list = Json::array();
  for (const Row& row : rows) list.push_back(value(row));
  return list;
}

Json description_json(const GraphDescription& description) {
  Json nodes = Json::array(), edges = Json::array();
  for (const NodeDescription& node : description.nodes)
    nodes.push_back({{"name", node.name}, {"kind", name_of(node.kind)}});
  for (const EdgeDescription& edge : description.edges) {
    edges.push_back({{"name", edge.name},
                     {"kind", name_of(edge.kind)},
                     {"from", edge.from},
                     {"to", edge.to},
                     {"next_round", edge.step == RoundStep::next},
                     {"value_type", edge.value_type}});
  }
  return {{"name", description.name}, {"nodes", nodes}, {"edges", edges}};
}

Json instances_json(const std::vector<DumpedInstance>& instances) {
  Json list = Json::array();
  for (const DumpedInstance& i : instances) {
    list.push_back(
        {{"number", i.number}, {"object", {i.object.home.value, i.object.number}}, {"rank", i.rank.value}});
  }
  return list;
}

Json network_json(const std::vector<NetworkLink>& links) {
  return {{"from", column(links, [](const NetworkLink& l) { return l.from; })},
          {"to", column(links, [](const NetworkLink& l) { return l.to; })},
          {"edge", column(links, [](const NetworkLink& l) { return l.edge; })},
          {"values", column(links, [](const NetworkLink& l) { return l.values; })},
          {"bytes", column(links, [](const NetworkLink& l) { return l.bytes; })}};
}

Json runs_json(const std::vector<DumpedRun>& runs, const std::vector<std::string>& names) {
  Json counters = Json::object();
  for (std::size_t c = 0; c < names.size(); ++c) {
    counters[names[c]] = column(
        runs, [&](const DumpedRun& r) { return c < r.counters.size() ? Json(r.counters[c]) : Json(0); });
  }
  return {{"node", column(runs, [](const DumpedRun& r) { return r.node; })},
          {"instance", column(runs, [](const DumpedRun& r) { return r.instance; })},
          {"round", column(runs, [](const DumpedRun& r) { return r.round; })},
          {"rank", column(runs, [](const DumpedRun& r) { return r.rank.value; })},
          {"begin_ns", column(runs, [](const DumpedRun& r) { return r.begin; })},
          {"duration_ns", column(runs, [](const DumpedRun& r) { return r.end - r.begin; })},
          {"bytes_received", column(runs, [](const DumpedRun& r) { return r.bytes_received; })},
          {"counters", counters}};
}

Json uses_json(const std::vector<DumpedUse>& uses) {
  return {{"edge", column(uses, [](const DumpedUse& u) { return u.edge; })},
          {"from", column(uses, [](const DumpedUse& u) { return u.from; })},
          {"to", column(uses, [](const DumpedUse& u) { return u.to; })},
          {"time_ns", column(uses, [](const DumpedUse& u) { return u.time; })},
          {"bytes", column(uses, [](const DumpedUse& u) { return u.bytes; })}};
}

Json path_json(const GraphDump& dump) {
  const CriticalPath& path = dump.critical_path;
  Json by_node = Json::array();
  for (const PathShare& share : shares_of(dump)) {
    by_node.push_back({{"node", dump.description.nodes[share.node].name},
                       {"runs", share.runs},
                       {"worked_ns", share.worked}});
  }
  using Step = CriticalPath::Step;
  return {{"length_ns", path.length},
          {"wall_ns", path.wall},
          {"by_node", by_node},
          {"runs", column(path.steps, [](const Step& s) { return s.run; })},
          {"worked_ns", column(path.steps, [](const Step& s) { return s.worked; })},
          {"uses",
           column(path.steps, [](const Step& s) { return s.arrived_by ? Json(*s.arrived_by) : Json(); })}};
}

// --- Reading

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument(std::string("no ") + kSchema + " document: " + what);
}

/// A member of a document, with its name for messages.
class Member {
 public:
  Member(const Json& json, std::string name) : json_(json), name_(std::move(name)) {}

  Member operator[](const char* key) const {
    if (!json_.is_object() || !json_.contains(key)) refuse("it lacks " + path(key));
    return {json_.at(key), path(key)};
  }
  std::vector<Member> items() const {
    if (!json_.is_array()) refuse(name_ + " is no list");
    std::vector<Member> all;
    for (std::size_t i = 0; i < json_.size(); ++i)
      all.emplace_back(json_[i], name_ + "[" + std::to_string(i) + "]");
    return all;
  }
  std::string string() const {
    if (!json_.is_string()) refuse(name_ + " is no text");
    return json_.get<std::string>();
  }
  bool boolean() const {
    if (!json_.is_boolean()) refuse(name_ + " is neither true nor false");
    return json_.get<bool>();
  }
  double number() const {
    if (!json_.is_number()) refuse(name_ + " is no number");
    return json_.get<double>();
  }
  /// A count or an index.
  template <class T = std::uint64_t>
  T natural() const {
    if (!json_.is_number_integer() || (!json_.is_number_unsigned() && json_.get<std::int64_t>() < 0))
      refuse(name_ + " is no natural number");
    const auto value = json_.get<std::uint64_t>();
    if (!std::in_range<T>(value)) refuse(name_ + " is too large");
    return static_cast<T>(value);
  }
  template <class T = std::uint32_t>
  T index(std::size_t size) const {
    const auto value = natural<T>();
    if (value >= size) refuse(name_ + " is out of range");
    return value;
  }
  engine::Rank rank() const { return engine::Rank(natural<std::int32_t>()); }
  bool is_null() const { return json_.is_null(); }
  const Json& json() const { return json_; }
  const std::string& name() const { return name_; }

  /// A column's numbers, which must be `size`.
  template <class T>
  std::vector<T> column(std::size_t size) const {
    const std::vector<Member> all = items();
    if (all.size() != size) refuse(name_ + " is not as long as the other columns");
    std::vector<T> values;
    for (const Member& m : all) {
      if constexpr (std::is_same_v<T, double>)
        values.push_back(m.number());
      else
        values.push_back(m.natural<T>());
    }
    return values;
  }
  std::size_t size() const {
    if (!json_.is_array()) refuse(name_ + " is no list");
    return json_.size();
  }

 private:
  std::string path(const char* key) const { return name_.empty() ? key : name_ + "." + key; }

  const Json& json_;
  std::string name_;
};

template <class Kind>
Kind kind_named(const Member& member, std::initializer_list<Kind> kinds) {
  const std::string name = member.string();
  for (const Kind kind : kinds)
    if (name == name_of(kind)) return kind;
  refuse(member.name() + " is '" + name + "'");
}

GraphDescription description_from(const Member& json) {
  GraphDescription description;
  description.name = json["name"].string();
  for (const Member& node : json["nodes"].items()) {
    description.nodes.push_back(
        {node["name"].string(),
         kind_named(node["kind"], {NodeKind::start, NodeKind::interior, NodeKind::event, NodeKind::wake})});
  }
  const std::size_t nodes = description.nodes.size();
  for (const Member& edge : json["edges"].items()) {
    description.edges.push_back(
        {edge["name"].string(), kind_named(edge["kind"], {EdgeKind::local, EdgeKind::remote, EdgeKind::wake}),
         edge["from"].index(nodes), edge["to"].index(nodes),
         edge["next_round"].boolean() ? RoundStep::next : RoundStep::same, edge["value_type"].string()});
  }
  return description;
}

std::vector<DumpedInstance> instances_from(const Member& json) {
  std::vector<DumpedInstance> instances;
  for (const Member& instance : json.items()) {
    const std::vector<Member> object = instance["object"].items();
    if (object.size() != 2) refuse(instance.name() + ".object is no pair");
    instances.push_back({instance["number"].natural(),
                         {object[0].rank(), object[1].natural<std::uint32_t>()},
                         instance["rank"].rank()});
  }
  return instances;
}

void check_below(const std::vector<std::uint32_t>& indices, std::size_t size, const Member& member) {
  for (const std::uint32_t i : indices)
    if (i >= size) refuse(member.name() + " has an index out of range");
}

std::vector<NetworkLink> network_from(const Member& json, const GraphDump& dump) {
  const std::size_t size = json["from"].size();
  const auto from = json["from"].column<std::uint32_t>(size), to = json["to"].column<std::uint32_t>(size);
  const auto edge = json["edge"].column<std::uint32_t>(size);
  const auto values = json["values"].column<std::uint64_t>(size);
  const auto bytes = json["bytes"].column<std::uint64_t>(size);
  check_below(from, dump.instances.size(), json["from"]);
  check_below(to, dump.instances.size(), json["to"]);
  check_below(edge, dump.description.edges.size(), json["edge"]);
  std::vector<NetworkLink> links(size);
  for (std::size_t i = 0; i < size; ++i) links[i] = {from[i], to[i], edge[i], values[i], bytes[i]};
  return links;
}

void read_counters(const Member& json, GraphDump& dump) {
  if (!json.json().is_object()) refuse(json.name() + " is no object");
  for (const auto& [name, column] : json.json().items()) {
    const auto values = Member(column, json.name() + "." + name).column<double>(dump.runs.size());
    const std::size_t index = dump.counter_names.size();
    dump.counter_names.push_back(name);
    for (std::size_t r = 0; r < values.size(); ++r) {
      if (values[r] == 0) continue;
      dump.runs[r].counters.resize(index + 1);
      dump.runs[r].counters[index] = values[r];
    }
  }
}

void read_runs(const Member& json, GraphDump& dump) {
  const std::size_t size = json["node"].size();
  const auto node = json["node"].column<std::uint32_t>(size),
             instance = json["instance"].column<std::uint32_t>(size);
  const auto round = json["round"].column<std::uint64_t>(size);
  const auto rank = json["rank"].column<std::int32_t>(size);
  const auto begin = json["begin_ns"].column<std::int64_t>(size);
  const auto duration = json["duration_ns"].column<std::int64_t>(size);
  const auto bytes = json["bytes_received"].column<std::uint64_t>(size);
  check_below(node, dump.description.nodes.size(), json["node"]);
  check_below(instance, dump.instances.size(), json["instance"]);
  for (std::size_t i = 0; i < size; ++i) {
    if (duration[i] > std::numeric_limits<std::int64_t>::max() - begin[i])
      refuse("runs.duration_ns is too large");
    dump.runs.push_back({node[i],
                         instance[i],
                         round[i],
                         engine::Rank(rank[i]),
                         begin[i],
                         begin[i] + duration[i],
                         bytes[i],
                         {}});
  }
  read_counters(json["counters"], dump);
}

void read_uses(const Member& json, GraphDump& dump) {
  const std::size_t size = json["edge"].size();
  const auto edge = json["edge"].column<std::uint32_t>(size);
  const auto from = json["from"].column<std::uint32_t>(size), to = json["to"].column<std::uint32_t>(size);
  const auto time = json["time_ns"].column<std::int64_t>(size);
  const auto bytes = json["bytes"].column<std::uint64_t>(size);
  check_below(edge, dump.description.edges.size(), json["edge"]);
  check_below(from, dump.runs.size(), json["from"]);
  check_below(to, dump.runs.size(), json["to"]);
  for (std::size_t i = 0; i < size; ++i) {
    if (time[i] < dump.runs[from[i]].begin || time[i] > dump.runs[from[i]].end)
      refuse("uses.time_ns[" + std::to_string(i) + "] is outside the run that sent it");
    if (i > 0 && to[i] < to[i - 1]) refuse("uses.to does not ascend");
    dump.uses.push_back({edge[i], from[i], to[i], time[i], bytes[i]});
  }
}

CriticalPath path_from(const Member& json, const GraphDump& dump) {
  CriticalPath path;
  path.length = json["length_ns"].natural<std::int64_t>();
  path.wall = json["wall_ns"].natural<std::int64_t>();
  const std::size_t size = json["runs"].size();
  const auto runs = json["runs"].column<std::uint32_t>(size);
  const auto worked = json["worked_ns"].column<std::int64_t>(size);
  const std::vector<Member> uses = json["uses"].items();
  if (uses.size() != size) refuse("critical_path.uses is not as long as the other columns");
  check_below(runs, dump.runs.size(), json["runs"]);
  for (std::size_t i = 0; i < size; ++i) {
    path.steps.push_back({runs[i], worked[i], {}});
    if (!uses[i].is_null()) path.steps.back().arrived_by = uses[i].index(dump.uses.size());
  }
  return path;
}

}  // namespace

nlohmann::ordered_json json_of(const GraphDump& dump) {
  return {{"schema", kSchema},
          {"graph", description_json(dump.description)},
          {"instances", instances_json(dump.instances)},
          {"network", network_json(dump.network)},
          {"runs", runs_json(dump.runs, dump.counter_names)},
          {"uses", uses_json(dump.uses)},
          {"unmatched_uses", dump.unmatched_uses},
          {"critical_path", dump.executed() ? path_json(dump) : Json()}};
}

GraphDump dump_from_json(const nlohmann::ordered_json& json) {
  const Member document(json, "");
  if (document["schema"].string() != kSchema) refuse("its schema is '" + document["schema"].string() + "'");
  GraphDump dump;
  dump.description = description_from(document["graph"]);
  dump.instances = instances_from(document["instances"]);
  dump.network = network_from(document["network"], dump);
  read_runs(document["runs"], dump);
  read_uses(document["uses"], dump);
  dump.unmatched_uses = document["unmatched_uses"].natural();
  if (!document["critical_path"].is_null()) dump.critical_path = path_from(document["critical_path"], dump);
  return dump;
}

}  // namespace weft::graph::dataflow

// One function for each member of the document.
#include "tools/report/profile.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "engine/json/json.h"
#include "graph/dataflow/dump/critical_path.h"
#include "graph/dataflow/dump/graph_json.h"
#include "tools/report/lanes.h"
#include "tools/report/operations.h"
#include "tools/report/published.h"

namespace weft::report {
namespace {

using Json = nlohmann::ordered_json;
using graph::dataflow::DumpedRun;
using graph::dataflow::GraphDump;
using graph::dataflow::Wait;

double seconds(engine::TimePoint nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

Json operations_json() {
  Json names = Json::array();
  for (const std::string_view name : kOperations) names.push_back(std::string(name));
  return names;
}

Json by_operation(const OperationSeconds& values) {
  Json json = Json::object();
  for (std::size_t o = 0; o < kOperations.size(); ++o) json[std::string(kOperations[o])] = values[o];
  return json;
}

struct RankTimes {
  Json ranks = Json::array();
  OperationSeconds sum{};
};

RankTimes rank_times(const engine::RunSummary& run, const GraphDump& graph) {
  RankTimes times;
  for (const engine::RankSummary& rank : run.ranks) {
    const OperationSeconds mine = seconds_of_rank(rank, graph);
    for (std::size_t o = 0; o < mine.size(); ++o) times.sum[o] += mine[o];
    times.ranks.push_back({{"rank", rank.rank.value},
                           {"workers", rank.workers},
                           {"wall", rank.wall},
                           {"seconds", by_operation(mine)},
                           {"communication", rank.times.communication},
                           {"packing", rank.times.pack},
                           {"peak_memory", rank.peak_rss}});
  }
  return times;
}

/// Waits summed by pairs of something.
class WaitSums {
 public:
  void add(std::uint64_t who, std::uint64_t for_whom, engine::TimePoint waited) {
    auto& [sum, count] = sums_[{who, for_whom}];
    sum += waited, ++count;
  }
  /// The longest ones first, at most `most`.
  Json json(const char* who, std::size_t most) const {
    std::vector<std::tuple<engine::TimePoint, std::uint64_t, std::uint64_t, std::uint64_t>> rows;
    for (const auto& [pair, entry] : sums_)
      rows.emplace_back(-entry.first, pair.first, pair.second, entry.second);
    std::sort(rows.begin(), rows.end());
    rows.resize(std::min(rows.size(), most));
    Json list = Json::array();
    for (const auto& [waited, first, second, count] : rows)
      list.push_back({{who, first}, {"for", second}, {"seconds", seconds(-waited)}, {"count", count}});
    return list;
  }

 private:
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::pair<engine::TimePoint, std::uint64_t>> sums_;
};

Json waiting_json(const GraphDump& graph, const ProfileOptions& options) {
  WaitSums ranks, subdomains;
  for (const Wait& wait : graph::dataflow::waits_of(graph)) {
    const DumpedRun &mine = graph.runs[wait.run], &theirs = graph.runs[wait.for_run];
    ranks.add(static_cast<std::uint64_t>(mine.rank.value), static_cast<std::uint64_t>(theirs.rank.value),
              wait.waited);
    subdomains.add(graph.instances[mine.instance].number, graph.instances[theirs.instance].number,
                   wait.waited);
  }
  return {{"ranks", ranks.json("rank", std::size_t(-1))},
          {"subdomains", subdomains.json("subdomain", options.most_waits)}};
}

Json critical_path_json(const GraphDump& graph) {
  const auto& path = graph.critical_path;
  OperationSeconds worked{};
  std::array<std::uint64_t, kOperations.size()> runs{};
  for (const auto& step : path.steps) {
    const DumpedRun& run = graph.runs[step.run];
    const std::string& node = graph.description.nodes[run.node].name;
    // What a run does beside counts by as much of the run as the path has.
    const double share = run.end > run.begin ? seconds(step.worked) / seconds(run.end - run.begin) : 0;
    BesideSeconds beside = beside_seconds(graph, run);
    for (std::size_t i = 0; i < beside.size(); ++i) {
      beside[i] *= share;
      runs[kBeside[i].operation] += beside[i] > 0;
    }
    add_seconds(node, seconds(step.worked), beside, worked);
    ++runs[operation_of_node(node)];
  }
  Json parts = Json::array();
  for (OperationIndex o = 0; o < kOperations.size(); ++o)
    if (runs[o] > 0)
      parts.push_back(
          {{"operation", std::string(kOperations[o])}, {"seconds", worked[o]}, {"runs", runs[o]}});
  return {{"seconds", seconds(path.length)},
          {"wall", seconds(path.wall)},
          {"share_of_wall", path.wall > 0 ? seconds(path.length) / seconds(path.wall) : 0.0},
          {"by_operation", parts}};
}

/// The counters of the nodes that adapt which say how much is left to do, not how much was done.
constexpr std::array<const char*, 4> kLeft = {"tets", "poor tets", "long edges", "short edges"};
constexpr std::array<const char*, 2> kParts = {"interior", "interface"};
std::string left_name(const char* what, const char* part) { return std::string(what) + ", " + part; }

/// Whether the document has a counter elsewhere than among those of the rounds, or its sum means nothing.
bool has_its_place(const std::string& counter) {
  if (counter == "colour" || counter == "tets predicted" || counter == "processor, seconds") return true;
  for (const Beside& beside : kBeside)
    if (counter == beside.counter) return true;
  for (const char* what : kLeft)
    for (const char* part : kParts)
      if (counter == left_name(what, part)) return true;
  return false;
}

/// What the nodes have done, by round.
Json convergence_json(const GraphDump& graph) {
  struct Round {
    std::vector<double> counters;
    double seconds = 0;
  };
  std::map<std::uint64_t, Round> rounds;
  for (const DumpedRun& run : graph.runs) {
    Round& round = rounds[run.round];
    round.counters.resize(graph.counter_names.size());
    round.seconds += seconds(run.end - run.begin);
    for (std::size_t c = 0; c < run.counters.size(); ++c) round.counters[c] += run.counters[c];
  }
  Json list = Json::array();
  for (const auto& [number, round] : rounds) {
    Json counters = Json::object();
    for (std::size_t c = 0; c < round.counters.size(); ++c)
      if (!has_its_place(graph.counter_names[c])) counters[graph.counter_names[c]] = round.counters[c];
    list.push_back({{"round", number}, {"seconds", round.seconds}, {"counters", counters}});
  }
  return list;
}

/// What a node adapts: everything before the shifts of a phase, or what the shift of its round brings. In the
/// last round of a coarse phase nothing is adapted, so steps have numbers of their own.
struct Step {
  std::uint64_t number = 0;
  bool everything = false;
};
std::optional<Step> step_of(const GraphDump& graph, const DumpedRun& run) {
  const OperationIndex operation = operation_of_node(graph.description.nodes[run.node].name);
  if (operation == kInteriorAdaptation) return Step{run.round, true};
  if (operation == kShiftedAdaptation) return Step{run.round + 1, false};
  return {};
}

Json sums_left_json(const GraphDump& graph, const std::vector<std::vector<double>>& latest,
                    const char* part) {
  Json json = Json::object();
  for (const char* what : kLeft) {
    const auto name =
        std::find(graph.counter_names.begin(), graph.counter_names.end(), left_name(what, part));
    const auto place = static_cast<std::size_t>(name - graph.counter_names.begin());
    double sum = 0;
    for (const std::vector<double>& counters : latest) sum += place < counters.size() ? counters[place] : 0;
    json[what] = sum;
  }
  return json;
}

/// What is wrong in the whole mesh after each step: what a subdomain has counted last holds until it counts
/// again.
Json left_json(const GraphDump& graph) {
  struct Adaptations {
    bool of_everything = false;
    std::vector<const DumpedRun*> runs;
  };
  std::map<std::uint64_t, Adaptations> by_step;
  for (const DumpedRun& run : graph.runs)
    if (const auto step = step_of(graph, run)) {
      by_step[step->number].of_everything = step->everything;
      by_step[step->number].runs.push_back(&run);
    }
  const auto is_left = [](const std::string& counter) { return counter == left_name(kLeft[0], kParts[0]); };
  if (std::none_of(graph.counter_names.begin(), graph.counter_names.end(), is_left)) by_step.clear();
  Json list = Json::array();
  std::vector<std::vector<double>> latest(graph.instances.size());
  for (const auto& [step, adaptations] : by_step) {
    for (const DumpedRun* run : adaptations.runs) latest[run->instance] = run->counters;
    Json entry = {
        {"step", step}, {"everything", adaptations.of_everything}, {"subdomains", adaptations.runs.size()}};
    for (const char* part : kParts) entry[part] = sums_left_json(graph, latest, part);
    list.push_back(entry);
  }
  return list;
}

/// Leaves out the smallest uses beside the critical path where there are too many.
GraphDump limited(const GraphDump& graph, const ProfileOptions& options) {
  GraphDump left = graph;
  if (left.uses.size() <= options.most_uses) return left;
  std::vector<bool> keep(left.uses.size(), false);
  std::vector<std::uint32_t> order(left.uses.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return left.uses[a].bytes > left.uses[b].bytes; });
  for (std::size_t i = 0; i < options.most_uses; ++i) keep[order[i]] = true;
  for (const auto& step : left.critical_path.steps)
    if (step.arrived_by) keep[*step.arrived_by] = true;
  std::vector<std::uint32_t> old_to_new(left.uses.size());
  std::vector<graph::dataflow::DumpedUse> uses;
  for (std::size_t u = 0; u < keep.size(); ++u) {
    old_to_new[u] = static_cast<std::uint32_t>(uses.size());
    if (keep[u]) uses.push_back(left.uses[u]);
  }
  left.uses = std::move(uses);
  for (auto& step : left.critical_path.steps)
    if (step.arrived_by) step.arrived_by = old_to_new[*step.arrived_by];
  return left;
}

Json operation_of_nodes_json(const GraphDump& graph) {
  Json list = Json::array();
  for (const auto& node : graph.description.nodes) list.push_back(operation_of_node(node.name));
  return list;
}

Json lanes_json(const Lanes& lanes) {
  Json list = Json::array();
  for (const Lane& lane : lanes.lanes) list.push_back({{"rank", lane.rank.value}, {"name", lane.name}});
  Json of_run = Json::array();
  for (const auto& lane : lanes.of_run) of_run.push_back(lane ? Json(*lane) : Json());
  return {{"lanes", list}, {"of_run", of_run}};
}

void put_graph(const ProfileInput& input, const ProfileOptions& options, Json& json) {
  const GraphDump& graph = *input.graph;
  json["waiting"] = waiting_json(graph, options);
  json["critical_path"] = critical_path_json(graph);
  json["convergence"] = convergence_json(graph);
  json["left"] = left_json(graph);
  if (graph.runs.size() > options.most_runs) return;
  const GraphDump shown = limited(graph, options);
  json["graph"] = graph::dataflow::json_of(shown);
  json["uses_left_out"] = graph.uses.size() - shown.uses.size();
  json["operation_of_node"] = operation_of_nodes_json(graph);
  json["timeline"] = lanes_json(lanes_of(graph, input.timelines, input.start));
}

/// Without what the document has elsewhere or in fewer bytes.
Json report_json(Json report) {
  if (report.contains("subdomains") && report["subdomains"].is_object())
    for (const char* key : {"engine", "by_rank"}) report["subdomains"].erase(key);
  return report;
}
Json engine_json(const engine::RunSummary& run) {
  Json json = engine::json_of(run);
  for (Json& rank : json["per_rank"])
    for (const char* key : {"peers", "methods", "worker_compute"}) rank.erase(key);
  return json;
}

/// What was sent from rank to rank, by columns: 256 ranks have 65,536 pairs.
Json messages_json(const engine::RunSummary& run) {
  Json from = Json::array(), to = Json::array(), messages = Json::array(), bytes = Json::array();
  for (const engine::RankSummary& rank : run.ranks) {
    for (const engine::PeerSummary& peer : rank.peers) {
      if (peer.volume.sent.messages == 0) continue;
      from.push_back(rank.rank.value), to.push_back(peer.rank.value);
      messages.push_back(peer.volume.sent.messages), bytes.push_back(peer.volume.sent.bytes);
    }
  }
  return {{"from", from}, {"to", to}, {"messages", messages}, {"bytes", bytes}};
}

Json hardware_json(const std::vector<Hardware>& kinds) {
  Json list = Json::array();
  for (const Hardware& kind : kinds) {
    list.push_back({{"ranks", kind.ranks},
                    {"processor", kind.processor},
                    {"cores", kind.cores},
                    {"memory", kind.memory}});
  }
  return list;
}

Json memory_json(const std::vector<MemorySamples>& all) {
  Json list = Json::array();
  for (const MemorySamples& samples : all)
    list.push_back({{"rank", samples.rank}, {"seconds", samples.seconds}, {"bytes", samples.bytes}});
  return list;
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json published_json(const std::string& case_name) {
  Json list = Json::array();
  for (const PublishedRun& run : published_runs(case_name)) {
    list.push_back({{"program", std::string(run.program)},
                    {"cores", run.cores},
                    {"seconds", optional_json(run.seconds)},
                    {"quality_mean", optional_json(run.quality_mean)},
                    {"quality_quantile_0.01", optional_json(run.quality_q01)},
                    {"quality_min", optional_json(run.quality_min)},
                    {"share_unit", optional_json(run.unit_edges)},
                    {"source", std::string(run.source)}});
  }
  return list;
}

Json published_curves_json(const std::string& case_name) {
  Json list = Json::array();
  for (const PublishedCurve& curve : published_curves(case_name)) {
    list.push_back({{"program", curve.program},
                    {"cores", curve.cores},
                    {"measure", curve.measure},
                    {"edges", curve.edges},
                    {"densities", curve.densities}});
  }
  return list;
}

}  // namespace

Json profile_json(const ProfileInput& input, const ProfileOptions& options) {
  Json json = {{"schema", "weft-profile-1"},
               {"case", input.case_name.empty() ? Json() : Json(input.case_name)},
               {"simulation", input.simulation != nullptr ? *input.simulation : Json()},
               {"report", report_json(input.report)},
               {"operations", operations_json()},
               {"total", nullptr},
               {"ranks", Json::array()},
               {"engine", nullptr},
               {"messages", nullptr},
               {"waiting", nullptr},
               {"critical_path", nullptr},
               {"convergence", Json::array()},
               {"left", Json::array()},
               {"graph", nullptr},
               {"uses_left_out", 0},
               {"operation_of_node", Json::array()},
               {"timeline", nullptr},
               {"memory", memory_json(input.memory)},
               {"hardware", hardware_json(input.hardware)},
               {"published", published_json(input.case_name)},
               {"published_curves", published_curves_json(input.case_name)},
               {"mesh", input.mesh.layers.empty() ? Json() : json_of(input.mesh, input.box)}};
  const GraphDump none;
  if (input.engine != nullptr) {
    const engine::RunSummary& run = *input.engine;
    RankTimes times = rank_times(run, input.graph != nullptr ? *input.graph : none);
    json["ranks"] = std::move(times.ranks);
    json["total"] = {{"workers", run.workers}, {"wall", run.wall}, {"seconds", by_operation(times.sum)}};
    json["engine"] = engine_json(run);
    json["messages"] = messages_json(run);
  }
  if (input.graph != nullptr && input.graph->executed()) put_graph(input, options, json);
  return json;
}

}  // namespace weft::report

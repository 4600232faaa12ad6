#include "tools/library/report/run_record.h"

#include <array>
#include <filesystem>
#include <iterator>
#include <map>
#include <sstream>

#include "engine/base/serialize.h"
#include "engine/base/text.h"
#include "engine/json/json.h"
#include "graph/dataflow/dump/graph_json.h"
#include "partition/communication/reduce.h"
#include "tools/library/jobs/distributed_stats.h"
#include "tools/library/report/graph_output.h"
#include "tools/library/report/report_json.h"
#include "tools/report/lanes.h"
#include "tools/report/profile.h"
#include "tools/report/report_page.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using graph::dataflow::RankExchange;

/// Vertices of a drawing; more are collapsed.
constexpr std::size_t kMostDrawn = 500;

/// The values of all ranks at rank 0, in their order; none elsewhere.
template <class T>
std::vector<T> gather(RankExchange& exchange, T mine) {
  std::vector<engine::Payload> to_each(static_cast<std::size_t>(exchange.runtime().ranks()));
  to_each[0] = engine::packed(std::move(mine));
  std::vector<engine::Payload> arrived = exchange.exchange(std::move(to_each));
  std::vector<T> all;
  if (exchange.runtime().rank().value != 0) return all;
  for (engine::Payload& payload : arrived) all.push_back(engine::unpacked<T>(std::move(payload)));
  return all;
}

/// The box of all ranks' points, the same everywhere.
meshing::Box common_box(partition::Peers& peers, const std::vector<partition::MeshPiece>& pieces) {
  meshing::Box box;
  for (const partition::MeshPiece& piece : pieces)
    for (const meshing::Point& p : piece.mesh.points) box.include(p);
  const std::vector<double> ends = partition::max(
      peers, std::vector<double>{-box.lo.x, -box.lo.y, -box.lo.z, box.hi.x, box.hi.y, box.hi.z});
  box.lo = {-ends[0], -ends[1], -ends[2]};
  box.hi = {ends[3], ends[4], ends[5]};
  return box;
}

}  // namespace

graph::dataflow::GraphDump executed_graph(const graph::dataflow::ExecutionLog& log,
                                          const graph::adaptation::AdaptationPlan& plan, int ranks) {
  std::map<engine::ObjectId, std::uint64_t> subdomain_of;
  for (partition::SubdomainId s(0); s.value < plan.subdomains; ++s.value)
    subdomain_of[graph::adaptation::object_of(plan, ranks, s).id] = s.value;
  return graph::dataflow::executed_dump(
      graph::dataflow::blueprint_of<graph::adaptation::SubdomainTask>().description(), log,
      [&](engine::ObjectId object) { return subdomain_of.at(object); });
}

void gather_runs(RankExchange& exchange, const graph::dataflow::ExecutionLog& log,
                 engine::TimePoint clock_offset, const graph::adaptation::AdaptationPlan& plan,
                 RunRecord& record) {
  engine::Runtime& runtime = exchange.runtime();
  record.ranks = runtime.ranks();
  record.timelines = runtime.gather_timelines();
  const std::vector<engine::TimePoint> offsets = gather(exchange, clock_offset);
  if (runtime.rank().value != 0) return;
  for (engine::RankTimeline& timeline : record.timelines)
    timeline.clock_offset = offsets[timeline.rank.index()];
  record.graph = executed_graph(log, plan, runtime.ranks());
  record.start = graph::dataflow::start_of(log);
}

graph::dataflow::GraphDump planned_graph(const std::vector<graph::adaptation::Neighbours>& neighbours,
                                         const graph::adaptation::AdaptationPlan& plan, int ranks) {
  std::vector<graph::dataflow::DumpedInstance> instances;
  for (partition::SubdomainId s(0); s.value < plan.subdomains; ++s.value) {
    const engine::ObjectId object = graph::adaptation::object_of(plan, ranks, s).id;
    instances.push_back({s.value, object, object.home});
  }
  std::vector<std::pair<graph::dataflow::InstanceIndex, graph::dataflow::InstanceIndex>> pairs;
  for (const graph::adaptation::Neighbours& n : neighbours)
    for (const partition::SubdomainId other : n.others) pairs.emplace_back(n.subdomain.value, other.value);
  return graph::dataflow::planned_dump(
      graph::dataflow::blueprint_of<graph::adaptation::SubdomainTask>().description(), std::move(instances),
      pairs);
}

void gather_plan(RankExchange& exchange, std::vector<graph::adaptation::Neighbours> mine,
                 const graph::adaptation::AdaptationPlan& plan, RunRecord& record) {
  std::vector<graph::adaptation::Neighbours> all;
  for (auto& part : gather(exchange, std::move(mine)))
    all.insert(all.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
  if (exchange.runtime().rank().value == 0)
    record.planned = planned_graph(all, plan, exchange.runtime().ranks());
}

void gather_machines(RankExchange& exchange, report::MemorySamples memory, RunRecord& record) {
  record.hardware = report::merge(gather(exchange, report::this_machine(exchange.runtime().rank().value)));
  record.memory = gather(exchange, std::move(memory));
}

void gather_view(RankExchange& exchange, partition::Peers& peers,
                 const std::vector<partition::MeshPiece>& pieces, const meshing::Model* model,
                 RunRecord& record) {
  const report::MeshViewOptions options;
  record.box = common_box(peers, pieces);
  std::vector<report::ViewedPiece> viewed;
  for (const partition::MeshPiece& piece : pieces)
    viewed.push_back({piece.mesh, piece.log_metrics, piece.subdomain.value});
  report::MeshView mine = report::mesh_view(viewed, record.box, options, model);
  for (report::MeshView& part : gather(exchange, std::move(mine))) append(record.mesh, std::move(part));
  thin_out(record.mesh, record.box, options);
}

RunRecord record_of(const meshing::MeshData& mesh, const meshing::LogMetricField& log_metrics,
                    const meshing::Model* model) {
  const report::MeshViewOptions options;
  RunRecord record;
  for (const meshing::Point& p : mesh.points) record.box.include(p);
  const std::array whole = {report::ViewedPiece{mesh, log_metrics}};
  record.mesh = report::mesh_view(whole, record.box, options, model);
  record.hardware = {report::this_machine(0)};
  return record;
}

void write_record(const RunResult& run, const RunRecord& record, const std::string& case_name) {
  const fs::path folder = fs::path(run.report_path).parent_path();
  const nlohmann::ordered_json report = json_of(run);
  const bool executed = record.graph.executed();
  const nlohmann::ordered_json profile =
      report::profile_json({.report = report,
                            .case_name = case_name,
                            .engine = run.distributed ? run.distributed->engine.get() : nullptr,
                            .graph = executed ? &record.graph : nullptr,
                            .timelines = record.timelines,
                            .start = record.start,
                            .hardware = record.hardware,
                            .memory = record.memory,
                            .mesh = record.mesh,
                            .box = record.box});
  write_text((folder / "profile.json").string(), text_of(profile) + "\n");
  write_text((folder / "report.html").string(), report::report_page(profile));
  if (executed) write_graph((folder / "graph.json").string(), record.graph);
}

void write_graph(const std::string& path, const graph::dataflow::GraphDump& graph) {
  using graph::dataflow::Collapse;
  const GraphFormat format = graph_format(path).value_or(GraphFormat::json);
  const bool drawn = format == GraphFormat::dot || format == GraphFormat::svg;
  const bool many = graph.runs.size() > kMostDrawn;
  write_text(path, graph_text(graph, format, drawn && many ? Collapse::rounds : Collapse::none));
}

std::string planned_path(const std::string& graph_path) {
  const fs::path path = graph_path;
  return (path.parent_path() / (path.stem().string() + "-planned" + path.extension().string())).string();
}

void write_planned_graph(const std::string& path, const graph::dataflow::GraphDump& graph) {
  using graph::dataflow::Collapse;
  const std::size_t nodes = graph.instances.size() * graph.description.nodes.size();
  const GraphFormat format = graph_format(path).value_or(GraphFormat::json);
  const bool drawn = format == GraphFormat::dot || format == GraphFormat::svg;
  write_text(path,
             graph_text(graph, format, drawn && nodes > kMostDrawn ? Collapse::instances : Collapse::none));
}

engine::Annotations trace_annotations(const RunRecord& record,
                                      const graph::adaptation::AdaptationPlan& plan) {
  using graph::dataflow::EdgeKind;
  const graph::dataflow::GraphDump& graph = record.graph;
  const int ranks = record.ranks;
  engine::Annotations annotations;
  annotations.ranks = ranks;
  annotations.object_kind = graph.description.name;
  annotations.number_of = [plan, ranks](engine::ObjectId object) -> std::optional<std::uint64_t> {
    const auto subdomain = subdomain_of(plan, ranks, object);
    return subdomain ? std::optional<std::uint64_t>(subdomain->value) : std::nullopt;
  };
  for (const auto& node : graph.description.nodes) annotations.names.push_back(node.name);
  for (const auto& edge : graph.description.edges) annotations.names.push_back(edge.name);
  const report::Lanes lanes = report::lanes_of(graph, record.timelines, record.start);
  for (std::size_t r = 0; r < graph.runs.size(); ++r) {
    const graph::dataflow::DumpedRun& run = graph.runs[r];
    const auto lane = lanes.of_run[r];
    const auto thread = lane ? lanes.lanes[*lane].thread : std::nullopt;
    annotations.steps.push_back({run.rank, thread.value_or(engine::Annotations::Step::kNoLane),
                                 run.begin + record.start, run.end + record.start, run.node,
                                 graph.instances[run.instance].number, run.round});
  }
  const auto nodes = static_cast<std::uint32_t>(graph.description.nodes.size());
  for (const graph::dataflow::DumpedUse& use : graph.uses)
    if (graph.description.edges[use.edge].kind == EdgeKind::remote)
      annotations.links.push_back({use.from, use.to, use.time + record.start, nodes + use.edge});
  return annotations;
}

void write_trace(const std::string& path, const RunRecord& record,
                 const graph::adaptation::AdaptationPlan& plan) {
  std::ostringstream text = engine::text_stream();
  engine::write_chrome_trace(text, record.timelines, trace_annotations(record, plan));
  write_text(path, text.str());
}

}  // namespace weft::tools

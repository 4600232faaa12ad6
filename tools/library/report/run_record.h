// What a run leaves in the folder of its report beside report.json, and what is gathered for that.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/trace/chrome_trace.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "graph/dataflow/dump/graph_dump.h"
#include "graph/dataflow/rank_exchange.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"
#include "tools/library/jobs/run_result.h"
#include "tools/report/hardware.h"
#include "tools/report/memory_sampler.h"
#include "tools/report/mesh_view.h"

namespace weft::tools {

/// The executed graph, its instances numbered as subdomains.
graph::dataflow::GraphDump executed_graph(const graph::dataflow::ExecutionLog& log,
                                          const graph::adaptation::AdaptationPlan& plan, int ranks);

/// The planned graph: who may send to whom. `neighbours`: of all subdomains.
graph::dataflow::GraphDump planned_graph(const std::vector<graph::adaptation::Neighbours>& neighbours,
                                         const graph::adaptation::AdaptationPlan& plan, int ranks);

/// Complete on rank 0 only; elsewhere what was gathered is empty.
struct RunRecord {
  graph::dataflow::GraphDump planned;
  graph::dataflow::GraphDump graph;
  engine::TimePoint start = 0;                  ///< what the graph's times count from
  int ranks = 0;                                ///< of the run
  std::vector<engine::RankTimeline> timelines;  ///< of the ranks that keep spans
  std::vector<report::Hardware> hardware;
  std::vector<report::MemorySamples> memory;
  report::MeshView mesh;
  meshing::Box box;
};

/// The graph and the timelines, on one clock. `log`: of all ranks, on rank 0; `clock_offset`: this rank's
/// when the log was gathered (a later comparison of the clocks differs by microseconds, more than many runs
/// take). All ranks must call it.
void gather_runs(graph::dataflow::RankExchange& exchange, const graph::dataflow::ExecutionLog& log,
                 engine::TimePoint clock_offset, const graph::adaptation::AdaptationPlan& plan,
                 RunRecord& record);

/// The planned graph. All ranks must call it.
void gather_plan(graph::dataflow::RankExchange& exchange, std::vector<graph::adaptation::Neighbours> mine,
                 const graph::adaptation::AdaptationPlan& plan, RunRecord& record);

/// What ranks know of hardware and memory, gathered. All ranks must call it.
void gather_machines(graph::dataflow::RankExchange& exchange, report::MemorySamples memory,
                     RunRecord& record);

/// The view of all pieces; `model`: that they lie on, or null. All ranks must call it.
void gather_view(graph::dataflow::RankExchange& exchange, partition::Peers& peers,
                 const std::vector<partition::MeshPiece>& pieces, const meshing::Model* model,
                 RunRecord& record);

/// The view of a whole mesh, and the machine. `model`: that it lies on, or null.
RunRecord record_of(const meshing::MeshData& mesh, const meshing::LogMetricField& log_metrics,
                    const meshing::Model* model);

/// profile.json and report.html in the folder of run.report_path, graph.json too where there is a graph.
/// Throws InputError.
void write_record(const RunResult& run, const RunRecord& record, const std::string& case_name);

/// For --graph: the format is that of the extension. Drawings of more than 500 runs are collapsed by rounds.
void write_graph(const std::string& path, const graph::dataflow::GraphDump& graph);

/// Where the planned graph is written beside the executed one: "run.svg" -> "run-planned.svg".
std::string planned_path(const std::string& graph_path);

/// The planned graph; drawings of more than 500 nodes show each subdomain as one.
void write_planned_graph(const std::string& path, const graph::dataflow::GraphDump& graph);

/// What the trace says of subdomains: their numbers, and the runs of the graph with its edges between
/// subdomains. Runs have the places that they have in graph.json.
engine::Annotations trace_annotations(const RunRecord& record, const graph::adaptation::AdaptationPlan& plan);

/// For --trace: Perfetto's format.
void write_trace(const std::string& path, const RunRecord& record,
                 const graph::adaptation::AdaptationPlan& plan);

}  // namespace weft::tools

#include "tests/tools/report/sample_run.h"

#include <algorithm>
#include <set>

#include "meshing/adapt/adapt.h"
#include "meshing/mesh/structured_box.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_field.h"
#include "tests/partition/communication/barrier_peers.h"
#include "tools/library/jobs/distributed_stats.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/report/report_json.h"
#include "tools/report/profile.h"

namespace weft::testing {
namespace {

struct Adapted {
  meshing::MeshData before;
  meshing::LogMetricField before_metric;
  meshing::AdaptResult after;
};

Adapted adapted_box(std::uint32_t cells) {
  Adapted result;
  result.before = meshing::structured_box({.cells = {cells, cells, cells}});
  result.before_metric = meshing::sample(meshing::AnalyticMetric("polar-1"), result.before);
  meshing::scale_to_complexity(result.before, 100.0 * cells, result.before_metric);
  result.after = meshing::adapt(result.before, {&result.before, &result.before_metric}, {});
  return result;
}

tools::RunResult account_of(const Adapted& mesh, const SimulationRules& rules,
                            const SimulatedRun& simulated) {
  tools::RunResult run;
  run.arguments = {"adapt",   "box.meshb",    "--metric-fn",
                   "polar-1", "--subdomains", std::to_string(rules.subdomains),
                   "-o",      "layer.meshb"};
  run.input_counts = tools::count(mesh.before);
  run.output_counts = tools::count(mesh.after.mesh);
  run.before = meshing::measure(mesh.before, mesh.before_metric);
  run.after = meshing::measure(mesh.after.mesh, mesh.after.log_metrics);
  const meshing::AdaptReport& report = mesh.after.report;
  run.stages = report.stages;
  run.operations = report.counts;
  run.surface_deviation = report.surface_deviation;
  run.surface_demands = report.surface_demands;
  run.target_complexity = run.before->complexity;
  run.times = {.read = 0.2,
               .metric = 0.1,
               .decompose = 0.1,
               .adapt = simulated.summary.wall,
               .measure = 0.3,
               .write = 0.2,
               .total = simulated.summary.wall + 0.9};
  run.warnings = {"a \"warning\" with <b>markup</b> & </script>"};
  std::vector<graph::adaptation::ShiftRecord> shifts(rules.rounds);
  for (std::size_t s = 0; s < shifts.size(); ++s)
    shifts[s] = {s, std::uint64_t{4000} >> s, 900, std::uint64_t{9000} >> s, 3000};
  DistributedStats account;
  partition::run_on_ranks(static_cast<int>(simulated.summary.ranks.size()), [&](partition::Peers& peers) {
    const engine::RankSummary& summary = simulated.summary.ranks[static_cast<std::size_t>(peers.rank())];
    const bool first = peers.rank() == 0;  // which knows of all
    const graph::dataflow::ExecutionLog& log = first ? simulated.log : graph::dataflow::ExecutionLog();
    DistributedStats of_rank =
        tools::account_for(peers, tools::seconds_of_rank(peers, log, summary),
                           first ? shifts : std::vector<graph::adaptation::ShiftRecord>(), true);
    if (first) account = std::move(of_rank);
  });
  tools::add_engine(simulated.summary, account);
  account.subdomains = rules.subdomains;
  account.partitioner = "bisection";
  account.former_interface = *run.after;
  run.distributed = std::make_shared<DistributedStats>(std::move(account));
  return run;
}

/// The part of the mesh between two planes across x, as if it were a subdomain.
meshing::MeshData slab(const meshing::MeshData& mesh, double from, double to) {
  meshing::MeshData part = mesh;
  part.tets.clear(), part.tet_refs.clear(), part.triangles.clear(), part.triangle_refs.clear();
  std::set<std::array<std::uint32_t, 3>> faces;
  for (const auto& tet : mesh.tets) {
    double x = 0;
    for (const std::uint32_t v : tet) x += mesh.points[v].x / 4;
    if (x < from || x >= to) continue;
    part.tets.push_back(tet), part.tet_refs.push_back(1);
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      std::array<std::uint32_t, 3> face;
      for (std::size_t i = 0, k = 0; i < 4; ++i)
        if (i != left_out) face[k++] = tet[i];
      std::ranges::sort(face);
      faces.insert(face);
    }
  }
  for (const auto& triangle : mesh.triangles) {
    auto key = triangle;
    std::ranges::sort(key);
    if (faces.contains(key)) part.triangles.push_back(triangle), part.triangle_refs.push_back(1);
  }
  return part;
}

report::MeshView view_of(const meshing::AdaptResult& result, const meshing::Box& box,
                         std::uint32_t subdomains) {
  std::vector<meshing::MeshData> slabs;
  for (std::uint32_t s = 0; s < subdomains; ++s)
    slabs.push_back(slab(result.mesh, 1.0 * s / subdomains, (s + 1.0) / subdomains));
  std::vector<report::ViewedPiece> pieces;
  for (std::uint32_t s = 0; s < subdomains; ++s) pieces.push_back({slabs[s], result.log_metrics, s});
  return report::mesh_view(pieces, box, {});
}

}  // namespace

SampleRun sample_run(const SimulationRules& rules, std::uint32_t cells) {
  SampleRun sample;
  sample.simulated = simulate(rules);
  sample.graph =
      graph::dataflow::executed_dump(sample.simulated.graph, sample.simulated.log,
                                     [&](engine::ObjectId o) { return subdomain_of_object(rules, o); });
  sample.start = graph::dataflow::start_of(sample.simulated.log);
  const Adapted mesh = adapted_box(cells);
  const nlohmann::ordered_json report = tools::json_of(account_of(mesh, rules, sample.simulated));
  meshing::Box box;
  for (const meshing::Point& p : mesh.after.mesh.points) box.include(p);
  std::vector<report::MemorySamples> memory;
  for (int r = 0; r < static_cast<int>(rules.ranks); ++r)
    memory.push_back({r, {0, 0.5, 1, 1.5}, {100'000'000, 300'000'000, 350'000'000, 340'000'000}});
  std::vector<report::Hardware> hardware;
  for (int r = 0; r < static_cast<int>(rules.ranks); ++r) hardware.push_back(report::this_machine(r));
  sample.profile = report::profile_json({.report = report,
                                         .case_name = "cube-polar2-500000",
                                         .engine = &sample.simulated.summary,
                                         .graph = &sample.graph,
                                         .timelines = sample.simulated.timelines,
                                         .start = sample.start,
                                         .hardware = report::merge(hardware),
                                         .memory = memory,
                                         .mesh = view_of(mesh.after, box, 8),
                                         .box = box});
  return sample;
}

}  // namespace weft::testing

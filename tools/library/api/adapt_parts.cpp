// Adaptation of a mesh in parts, on a caller's communicator.
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/run/runtime.h"
#include "graph/adaptation/engine_peers.h"
#include "meshing/base/error.h"
#include "partition/communication/agreement.h"
#include "partition/communication/point_limit.h"
#include "partition/communication/reduce.h"
#include "partition/fields/piece_slices.h"
#include "tools/common/naming.h"
#include "tools/library/jobs/distributed_run.h"
#include "tools/library/jobs/ranks.h"
#include "tools/library/jobs/resources/memory.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/jobs/sources/metric_in_parts.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/parts/part_fields.h"
#include "tools/library/parts/part_input.h"
#include "tools/library/parts/part_output.h"
#include "tools/library/parts/part_solutions.h"
#include "weft/weft.h"

namespace weft {
namespace {

/// A metric that is scaled alone is so in parts; anything else looks at the whole mesh.
bool only_scaled(const MetricOptions& options) {
  return tools::scaled_alone(options) && options.file.empty() && options.function.empty();
}

/// The metric of the slices' mesh: what `metric` (null: nothing) and the options give. Returns the complexity
/// that it still has to be scaled to.
double add_metric(partition::Peers& peers, const Part& part, const Metric* metric, const Options& options,
                  const std::shared_ptr<const meshing::Model>& model,
                  const std::optional<tools::SurfaceBound>& bound, const std::atomic<bool>* interrupt,
                  partition::MeshSlice& slice, Report& report) {
  // Ranks without points need not have the solutions.
  const bool solves = partition::max(peers, options.metric.solutions.empty() ? 0 : 1) != 0;
  if (metric && !solves && only_scaled(options.metric) && !bound) return options.metric.complexity;
  MetricOptions of_slice = options.metric;
  if (solves) of_slice.solutions = {tools::solutions_of_slices(peers, part, options.metric.solutions)};
  tools::LogMetricMade made =
      tools::make_metric_in_parts(peers, of_slice, slice, "", model, bound, interrupt);
  slice.log_metrics = std::move(made.field);
  report.warnings.insert(report.warnings.end(), made.warnings.begin(), made.warnings.end());
  report.surface_limit = made.surface_limit;
  return 0;
}

/// All ranks: they go through different steps with a `what` and without.
void agree_that_given(partition::Peers& peers, bool given, const std::string& what) {
  const int mine = given ? 1 : 0;
  if (partition::max(peers, mine) != -partition::max(peers, -mine))
    throw InputError("", what, "some ranks give one, others do not");
}

/// Another mesh that has the metric (null: that options make), with which nothing is to be done any more.
partition::MeshSlice background_of(partition::Peers& peers, const Part& part, const Metric* metric,
                                   const Options& options, const std::shared_ptr<const meshing::Model>& model,
                                   const std::atomic<bool>* interrupt, Report& report) {
  return tools::naming("background", [&] {
    partition::MeshSlice slice = tools::slice_of_parts(peers, part, metric);
    if (add_metric(peers, part, metric, options, model, {}, interrupt, slice, report) > 0) {
      tools::LogMetricMade made =
          tools::make_metric_in_parts(peers, options.metric, slice, "", nullptr, {}, interrupt);
      slice.log_metrics = std::move(made.field);
      report.warnings.insert(report.warnings.end(), made.warnings.begin(), made.warnings.end());
    }
    slice.boundary = {};
    partition::count_boundary(peers, slice);
    return slice;
  });
}

void carry_fields(tools::DistributedRun& run, partition::MeshSlice&& old, const Fields& fields,
                  TransferMethod method, PartResult& result) {
  const partition::Numbering& numbering = run.numbering();
  if (const std::string issue = partition::too_many_points(numbering.totals.points); !issue.empty()) {
    result.warnings.push_back("fields are not carried to the result: " + issue);  // it is not lost with them
    return;
  }
  partition::MeshSlice slice = partition::slice_of_pieces(run.peers(), run.pieces(), numbering);
  Transfer transfer = run.carry(std::move(old), fields, slice, result.left_as_is.has_value());
  result.part.fields = tools::fields_at(run.peers(), slice, transfer.fields, result.part.ids);
  tools::account_for_transfer(transfer, method, "", result);
}

/// `background`: the part that `metric` belongs to; null: `part`.
PartResult adapt_part(engine::Transport& transport, const Part& part, const Part* background,
                      const Metric* metric, const Options& options) {
  tools::Stopwatch watch, total;
  tools::DistributedRun run(options, transport);
  PartResult result;
  agree_that_given(run.peers(), background != nullptr, "background");
  agree_that_given(run.peers(), metric != nullptr, "metric");
  partition::MeshSlice slice = tools::slice_of_parts(run.peers(), part, background ? nullptr : metric);
  const auto model = run.read_model(part.mesh, "");
  const std::atomic<bool>* interrupt = tools::flag_for_metric(run.monitor(), options.checkpoint);
  double target = 0;
  result.times.read = watch.lap();
  std::optional<partition::MeshSlice> of_metric;
  if (background)
    of_metric = background_of(run.peers(), *background, metric, options, model, interrupt, result);
  else
    target = add_metric(run.peers(), part, metric, options, model,
                        tools::surface_bound_in_parts(run.peers(), options.geometry, slice), interrupt, slice,
                        result);
  result.times.metric = watch.lap();
  result.input_counts = {slice.num_points, slice.num_tets, slice.num_triangles, slice.num_edges};
  const Fields fields = tools::fields_of_slices(run.peers(), part);
  partition::MeshSlice old;
  if (!fields.fields.empty()) old = partition::without_boundary(slice);
  result.times.read += watch.lap();
  run.adapt(std::move(slice), target, "", result, of_metric ? &*of_metric : nullptr);
  watch.lap();
  if (options.run.measure) run.measure(result);
  result.times.measure = watch.lap();
  run.on_threads([&] {
    tools::PartWithMetric out = tools::part_of_pieces(run.peers(), run.pieces(), options.distributed.ghosts);
    result.part = std::move(out.part);
    result.metric = std::move(out.metric);
    result.times.write = watch.lap();
    if (!fields.fields.empty()) carry_fields(run, std::move(old), fields, options.transfer, result);
  });
  result.times.fields = watch.lap();
  result.times.total = total.lap();
  result.peak_memory = partition::max(run.peers(), tools::peak_memory_bytes());
  return result;
}

PartResult adapt_checked(MPI_Comm communicator, const Part& part, const Part* background,
                         const Metric* metric, const Options& options) {
  PartResult result;
  const auto adapt_here = [&](engine::Transport& transport) {
    validate(options);  // on the transport: what is wrong on one rank, all hear
    if (options.run.repair) throw OptionError("--repair", "is not possible for a mesh in parts");
    result = adapt_part(transport, part, background, metric, options);
  };
  tools::on_communicator(communicator, adapt_here);
  return result;
}

}  // namespace

PartResult adapt(MPI_Comm communicator, const Part& part, const Metric& metric, const Options& options) {
  return adapt_checked(communicator, part, nullptr, &metric, options);
}

PartResult adapt(MPI_Comm communicator, const Part& part, const Part& background, const Metric& metric,
                 const Options& options) {
  return adapt_checked(communicator, part, &background, &metric, options);
}

PartResult adapt(MPI_Comm communicator, const Part& part, const Part& background, const Options& options) {
  return adapt_checked(communicator, part, &background, nullptr, options);
}

PartResult adapt(MPI_Comm communicator, const Part& part, const Options& options) {
  return adapt_checked(communicator, part, nullptr, nullptr, options);
}

RankError first_error(MPI_Comm communicator, const std::string& error) {
  RankError first;
  tools::on_communicator(communicator, [&](engine::Transport& transport) {
    engine::Registry registry;
    graph::adaptation::EnginePeers::register_types(registry);
    engine::Runtime runtime(transport, registry, {});
    graph::adaptation::EnginePeers peers(runtime);
    const auto all = partition::allgather(peers, std::vector<char>(error.begin(), error.end()));
    const auto found = std::ranges::find_if(all, [](const auto& text) { return !text.empty(); });
    if (found != all.end()) first = {static_cast<int>(found - all.begin()), {found->begin(), found->end()}};
  });
  return first;
}

}  // namespace weft

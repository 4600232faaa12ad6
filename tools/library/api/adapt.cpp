// Adaptation of one mesh in memory, as one or in subdomains; adaptation of files.
#include <atomic>
#include <utility>
#include <vector>

#include "engine/json/json.h"
#include "engine/mpi/mpi_transport.h"
#include "meshing/base/error.h"
#include "meshing/base/release.h"
#include "meshing/fields/transfer.h"
#include "meshing/metric/measures.h"
#include "partition/output/merge_pieces.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/adapt_one.h"
#include "tools/library/jobs/distributed_run.h"
#include "tools/library/jobs/file_job.h"
#include "tools/library/jobs/ranks.h"
#include "tools/library/jobs/resources/memory.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/jobs/sources/repaired_input.h"
#include "tools/library/jobs/sources/shares.h"
#include "tools/library/report/report_json.h"
#include "tools/library/report/summary.h"
#include "tools/report/published.h"

namespace weft {
namespace {

/// A metric that is only scaled is scaled by all subdomains together, as in runs on ranks.
Result adapt_in_subdomains(const tools::AdaptInput& input, const Options& options,
                           const tools::Monitor& monitor) {
  Result result;
  tools::Stopwatch watch;
  result.input_counts = tools::count(input.mesh);
  MetricOptions metric = options.metric;
  const auto bound = input.background ? std::nullopt : tools::surface_bound(options.geometry, input.mesh);
  const bool in_parts = tools::scaled_alone(metric) && !input.background && !bound;
  const double target = in_parts ? std::exchange(metric.complexity, 0) : 0;
  std::atomic<bool> waited = false;  // the caller, for the run's end
  tools::on_one_rank([&](engine::Transport& transport) {
    tools::DistributedRun run(options, transport);
    const meshing::MeshData& owner = input.background ? *input.background : input.mesh;
    tools::LogMetricMade made =
        tools::make_log_metric(metric, owner, input.background ? input.background_name : input.name,
                               input.metric, run.read_model(input.mesh, input.name), bound,
                               tools::flag_for_metric(run.monitor(), options.checkpoint));
    result.warnings = std::move(made.warnings);
    result.surface_limit = made.surface_limit;
    partition::MeshSlice of_metric = tools::deal_out(run.peers(), owner, made.field), of_mesh;
    if (input.background) of_mesh = tools::deal_out(run.peers(), input.mesh, {});
    if (options.run.measure && !input.background) {
      if (target > 0) meshing::scale_to_complexity(input.mesh, target, made.field);
      result.before = meshing::measure(input.mesh, made.field);
    }
    meshing::release(made.field);
    run.adapt(std::move(input.background ? of_mesh : of_metric), target, input.name, result,
              input.background ? &of_metric : nullptr);
    if (options.run.measure && !result.cancelled) run.measure(result);
    partition::MergedMesh merged = partition::merge_pieces(run.pieces());
    result.mesh = std::move(merged.mesh);
    if (!options.geometry.model.empty()) {
      result.mesh.association.model = input.mesh.association.model;
      result.mesh.association.model_in_words = input.mesh.association.model_in_words;
    }
    result.metric = Metric::from_logarithms(std::move(merged.log_metrics));
    waited = run.monitor().caller_waits().load();
  });
  result.output_counts = tools::count(result.mesh);
  if (!input.fields.fields.empty()) {
    Transfer carried =
        result.left_as_is
            ? meshing::keep_fields(meshing::WholeDomain(input.mesh), input.fields, options.transfer)
            : meshing::transfer(input.mesh, input.fields, result.mesh, options.transfer,
                                waited ? &waited : &monitor.caller_waits());
    tools::account_for_transfer(carried, options.transfer, "", result);
    result.fields = std::move(carried.fields);
  }
  return result;
}

Result adapt_input(const tools::AdaptInput& input, const Options& options) {
  tools::Stopwatch watch;
  tools::Monitor monitor(options.run);
  Result result = options.distributed.asked()
                      ? tools::with_threads(tools::number_of_threads(options.run.threads),
                                            [&] { return adapt_in_subdomains(input, options, monitor); })
                      : tools::adapt_one(input, options, monitor);
  result.times.total = watch.lap();
  result.peak_memory = tools::peak_memory_bytes();
  return result;
}

void check_solutions(const Mesh& mesh, const MetricOptions& options) {
  for (const Fields& solution : options.solutions) {
    check_length(mesh, solution.num_points, "solution");
    check_fields(mesh, solution);
  }
}

/// Of a copy that is mended first; what is at its vertices follows, in memory and in files.
Result adapt_mended(const Mesh& mesh, const Metric* metric, Options options, Fields fields) {
  Mesh mended = mesh;
  options.run.repair = false;
  if (metric) check_length(mesh, metric->size(), "metric");
  check_fields(mesh, fields);
  check_solutions(mesh, options.metric);
  tools::RepairedMetric repaired = tools::repair_input(mended, "", options.metric, fields);
  if (metric) {
    std::vector<Tensor> logarithms;
    for (const std::uint32_t p : repaired.points) logarithms.push_back(metric->logarithms()[p]);
    tools::combine(std::move(logarithms), repaired.source);
  }
  Result result = repaired.source
                      ? adapt(mended, Metric::from_logarithms(std::move(*repaired.source)), options, fields)
                      : adapt(mended, options, fields);
  result.mends = std::move(repaired.mends);
  return result;
}

void refuse_repair_beside_background(const Options& options) {
  if (options.run.repair)
    throw OptionError("--repair", "call repair() for a mesh with a background of its own");
}

}  // namespace

Result adapt(const Mesh& mesh, const Metric& metric, const Options& options, const Fields& fields) {
  validate(options);
  if (options.run.repair) return adapt_mended(mesh, &metric, options, fields);
  const WholeMesh whole(mesh);
  check_length(mesh, metric.size(), "metric");
  check_fields(mesh, fields);
  return adapt_input({*whole, "", nullptr, "", &metric.logarithms(), fields}, options);
}

Result adapt(const Mesh& mesh, const Options& options, const Fields& fields) {
  validate(options);
  if (options.run.repair) return adapt_mended(mesh, nullptr, options, fields);
  const WholeMesh whole(mesh);
  check_fields(mesh, fields);
  return adapt_input({*whole, "", nullptr, "", nullptr, fields}, options);
}

Result adapt(const Mesh& mesh, const Mesh& background, const Metric& metric, const Options& options,
             const Fields& fields) {
  validate(options);
  refuse_repair_beside_background(options);
  const WholeMesh whole(mesh), whole_background(background);
  check_length(background, metric.size(), "metric");
  check_fields(mesh, fields);
  return adapt_input({*whole, "", &*whole_background, "", &metric.logarithms(), fields}, options);
}

Result adapt(const Mesh& mesh, const Mesh& background, const Options& options, const Fields& fields) {
  validate(options);
  refuse_repair_beside_background(options);
  const WholeMesh whole(mesh), whole_background(background);
  check_fields(mesh, fields);
  return adapt_input({*whole, "", &*whole_background, "", nullptr, fields}, options);
}

const Measures& measures(Result& result) {
  if (!result.after) {
    tools::Stopwatch watch;
    result.after = tools::with_threads(
        result.threads, [&] { return meshing::measure(result.mesh, result.metric.logarithms()); });
    result.missed = tools::missed_goals(result.after, result.complexity_asked ? result.target_complexity : 0,
                                        result.ended_by, result.model.get());
    result.times.measure += watch.lap();
  }
  return *result.after;
}

bool under_mpirun() { return engine::under_mpirun(); }

bool in_subdomains(const Options& options) { return options.distributed.asked() || under_mpirun(); }

FilesResult adapt_files(const Files& files, const Options& options) {
  validate(options);
  if (!options.metric.given())
    throw OptionError(
        "--metric",
        "no metric: give --sol FILE, --metric FILE, --metric-fn NAME (such as polar-2), --implied, "
        "--curvature N, --sagitta D or --wall REF");
  if (in_subdomains(options)) return tools::adapt_files_in_subdomains(files, options);
  if (options.run.check) throw OptionError("--check", "needs --subdomains");
  if (!files.graph.empty()) throw OptionError("--graph", "needs --subdomains");
  if (!files.trace.empty()) throw OptionError("--trace", "needs --subdomains");
  return tools::adapt_files_as_one(files, options);
}

std::vector<std::string> published_cases() {
  std::vector<std::string> names;
  for (const std::string_view name : report::published_cases()) names.emplace_back(name);
  return names;
}

std::string summary(const Report& report) { return tools::summary_text(report); }
std::string summary(const FilesResult& result) { return tools::summary_text(result); }

std::string to_json(const Measures& measures) { return tools::text_of(tools::json_of(measures), 1); }

std::string to_json(const Report& report) {
  tools::RunResult run;
  static_cast<Report&>(run) = report;
  return tools::text_of(tools::json_of(run), 1);
}

}  // namespace weft

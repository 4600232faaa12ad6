// Shares of files, or of a mesh that rank 0 has.
#include "tools/library/jobs/sources/slice_source.h"

#include <algorithm>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/fields/by_components.h"
#include "tools/library/jobs/file_outputs.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/metric_in_parts.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/jobs/sources/repaired_input.h"
#include "tools/library/jobs/sources/shares.h"

namespace weft::tools {
namespace {

using meshing::InputError;
using meshing::MeshData;
using partition::MeshSlice;
using partition::Peers;

/// The mesh that the metric belongs to is another one.
bool has_background(const Files& files) {
  return !files.background.empty() && !same_file(files.background, files.input);
}

/// A metric that is only scaled is scaled where all ranks know it.
void add_metric(Peers& peers, const Files& files, const Options& options,
                const std::shared_ptr<const meshing::Model>& model, const std::atomic<bool>* interrupt,
                SliceInput& input) {
  const std::optional<SurfaceBound> bound = surface_bound_in_parts(peers, options.geometry, input.slice);
  if (only_scaled(options.metric) && !bound) {
    input.target_complexity = options.metric.complexity;
    input.slice.log_metrics = metric_of_share(peers, options.metric, input.slice);
    return;
  }
  LogMetricMade made =
      make_metric_in_parts(peers, options.metric, input.slice, files.input, model, bound, interrupt);
  input.slice.log_metrics = std::move(made.field);
  input.warnings = std::move(made.warnings);
  input.surface_limit = made.surface_limit;
}

/// With its metric; nobody looks at its boundary.
void keep_background(Peers& peers, MeshSlice slice, SliceInput& input) {
  slice.boundary = {};
  count_boundary(peers, slice);
  input.background = std::move(slice);
}

/// The metric on its own mesh, with which nothing is to be done any more.
void add_background(Peers& peers, const Files& files, const Options& options,
                    const std::shared_ptr<const meshing::Model>& model, const std::atomic<bool>* interrupt,
                    SliceInput& input) {
  MeshShare share = read_mesh_share(peers, files.background);
  if (share.slice.num_tets == 0) throw InputError(files.background, "", "has no tetrahedra");
  Stopwatch watch;
  LogMetricMade made =
      make_metric_in_parts(peers, options.metric, share.slice, files.background, model, {}, interrupt);
  input.metric_seconds = watch.lap();
  share.slice.log_metrics = std::move(made.field);
  keep_background(peers, std::move(share.slice), input);
  input.warnings = std::move(made.warnings);
  if (share.read_whole && peers.ranks() > 1)
    input.warnings.push_back(read_whole_warning(files.background, "meshes"));
}

SliceInput read_share(Peers& peers, const Files& files, const Options& options,
                      const std::shared_ptr<const meshing::Model>& model,
                      const std::atomic<bool>* interrupt) {
  MeshShare share = read_mesh_share(peers, files.input);
  if (share.slice.num_tets == 0) throw InputError(files.input, "", "has no tetrahedra");
  SliceInput input;
  input.slice = std::move(share.slice);
  input.names = std::move(share.names);
  input.fields = read_fields_of_slice(peers, files.fields, input.slice, files.input);
  if (!has_background(files)) {
    Stopwatch watch;
    add_metric(peers, files, options, model, interrupt, input);
    input.metric_seconds = watch.lap();
  }
  if (share.read_whole && peers.ranks() > 1)
    input.warnings.push_back(read_whole_warning(files.input, "meshes"));
  return input;
}

/// What rank 0 does with the whole mesh: mends it, with what belongs to its vertices, and makes the metric
/// (without a background of its own).
SliceInput read_and_mend(Peers& peers, const Files& files, const Options& options,
                         const std::shared_ptr<const meshing::Model>& model,
                         const std::atomic<bool>* interrupt) {
  SliceInput input;
  MeshData whole;  // on rank 0, with what follows
  meshing::LogMetricField field;
  Fields fields;
  RepairedMetric repaired;
  MetricOptions metric = options.metric;
  std::optional<SurfaceBound> bound;
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    whole = meshing::read_mesh(files.input, &input.names, meshing::Coordinates::any);
    if (whole.tets.empty()) throw InputError(files.input, "", "has no tetrahedra");
    fields = read_all_fields(files.fields, whole.points.size(), files.input);
    MetricOptions none;
    repaired = repair_input(whole, files.input, has_background(files) ? none : metric, fields);
    input.mends = std::move(repaired.mends);
    bound = surface_bound(options.geometry, whole);
  });
  const bool is_bounded = partition::max(peers, bound ? 1 : 0) != 0;
  // By what all ranks have been asked for: rank 0 has the metric's file already.
  if (only_scaled(options.metric) && !is_bounded)
    input.target_complexity = std::exchange(metric.complexity, 0);
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0 || has_background(files)) return;
    Stopwatch watch;
    LogMetricMade made = make_log_metric(
        metric, whole, files.input, repaired.source ? &*repaired.source : nullptr, model, bound, interrupt);
    input.metric_seconds = watch.lap();
    field = std::move(made.field);
    input.warnings = std::move(made.warnings);
    input.surface_limit = made.surface_limit;
  });
  if (peers.ranks() > 1)
    input.warnings.push_back("rank 0 has read all of " + files.input + ": a mesh is not repaired in shares");
  input.slice = deal_out(peers, whole, field);
  input.fields = deal_fields(peers, fields, input.slice);
  return input;
}

/// The same of a background.
void mend_background(Peers& peers, const Files& files, const Options& options,
                     const std::shared_ptr<const meshing::Model>& model, const std::atomic<bool>* interrupt,
                     SliceInput& input) {
  MeshData whole;  // on rank 0, with its metric
  LogMetricMade made;
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    whole = meshing::read_mesh(files.background, nullptr, meshing::Coordinates::any);
    if (whole.tets.empty()) throw InputError(files.background, "", "has no tetrahedra");
    MetricOptions metric = options.metric;
    RepairedMetric repaired = repair_background(whole, files.background, metric);
    input.mends.insert(input.mends.end(), repaired.mends.begin(), repaired.mends.end());
    Stopwatch watch;
    made = make_log_metric(metric, whole, files.background, repaired.source ? &*repaired.source : nullptr,
                           model, {}, interrupt);
    input.metric_seconds = watch.lap();
    input.warnings.insert(input.warnings.end(), made.warnings.begin(), made.warnings.end());
  });
  keep_background(peers, deal_out(peers, whole, made.field), input);
}

/// Values at vertices in files of other formats than GMF.
void warn_of_fields(Peers& peers, const Files& files, const Options& options, SliceInput& input) {
  if (peers.ranks() == 1 || options.run.repair) return;
  std::vector<std::string> all = files_of(options.metric);
  all.insert(all.end(), files.fields.begin(), files.fields.end());
  for (const std::string& file : all)
    if (!fields_in_shares(file)) input.warnings.push_back(read_whole_warning(file, "fields"));
}

/// The values of all ranks on rank 0, in their order; elsewhere none.
template <class T>
std::vector<T> concentrate(Peers& peers, const std::vector<T>& mine) {
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers.ranks()));
  to_each[0] = mine;
  return all_to_all_joined(peers, std::move(to_each));
}

}  // namespace

SliceInput read_slice(Peers& peers, const Files& files, const Options& options,
                      const std::shared_ptr<const meshing::Model>& model,
                      const std::atomic<bool>* interrupt) {
  SliceInput input = options.run.repair ? read_and_mend(peers, files, options, model, interrupt)
                                        : read_share(peers, files, options, model, interrupt);
  warn_of_fields(peers, files, options, input);
  if (has_background(files)) {
    input.target_complexity = 0;
    if (options.run.repair)
      mend_background(peers, files, options, model, interrupt, input);
    else
      add_background(peers, files, options, model, interrupt, input);
  }
  return input;
}

Fields gather_to_first(Peers& peers, const Fields& mine) {
  const auto points = partition::sum(peers, std::uint64_t{mine.num_points});
  return partition::by_components(mine, peers.rank() == 0 ? points : 0,
                                  [&](const auto& column) { return concentrate(peers, column); });
}

}  // namespace weft::tools

// Every rank reads the values of its slice; owners of vertices get them from there.
#include "tools/library/jobs/sources/metric_in_parts.h"

#include <optional>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/metric/sources/hessian.h"
#include "meshing/metric/sources/multiscale.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/metric/curvature_in_parts.h"
#include "partition/metric/part_domain.h"
#include "partition/metric/wall_metric_in_parts.h"
#include "tools/common/naming.h"
#include "tools/library/jobs/sources/shares.h"

namespace weft::tools {
namespace {

using partition::MeshSlice;
using partition::PartDomain;
using partition::Peers;

/// The values of a file at this rank's slice of points. `kind`: what it is called where it is of another
/// mesh.
Fields read_share_of(Peers& peers, const std::string& file, const MeshSlice& slice, const std::string& kind) {
  return read_fields_share(peers, file, slice, [&](std::uint64_t length) {
    return kind + " of another mesh: it has " + std::to_string(length) + " vertices, the mesh " +
           std::to_string(slice.num_points);
  });
}

/// The scalar fields at the vertices of the part.
Fields of_part(const PartDomain& domain, const Fields& of_slice) {
  Fields fields{domain.mesh().points.size(), {}};
  for (const Field& field : of_slice.fields)
    if (field.kind == Field::Kind::scalar)
      fields.fields.push_back({field.kind, domain.from_slices(field.values), field.name});
  return fields;
}

/// The scalar fields of a file, checked, at the vertices of the part.
Fields read_fields(Peers& peers, const MeshSlice& slice, const PartDomain& domain, const std::string& file) {
  const Fields of_slice = read_share_of(peers, file, slice, "solution");
  partition::agree_on(
      peers, [&] { meshing::scalar_fields(of_slice, slice.points.size(), file, slice.first_point); });
  return of_part(domain, of_slice);
}

/// The metric of a file at the points of the slice.
meshing::LogMetricField metric_of_slice(Peers& peers, const std::string& file, const MeshSlice& slice) {
  const Fields fields = read_share_of(peers, file, slice, "metric");
  meshing::LogMetricField metric;
  partition::agree_on(peers, [&] {
    metric = meshing::metric_from_solution(fields, slice.points.size(), file, slice.first_point);
  });
  return metric;
}

/// All ranks: boundary_demand() at the vertices of the part.
std::optional<meshing::LogMetricField> demand_in_part(Peers& peers, const MetricOptions& options,
                                                      const MeshSlice& slice, const PartDomain& domain,
                                                      const std::shared_ptr<const meshing::Model>& model) {
  std::optional<meshing::LogMetricField> field;
  if (const auto curvature = curvature_options(options))
    combine(partition::curvature_in_parts(peers, slice, domain, *curvature, model), field);
  if (!options.wall.refs.empty())
    combine(partition::wall_metric_in_parts(peers, slice, domain, options.wall), field);
  return field;
}

}  // namespace

bool only_scaled(const MetricOptions& options) {
  return scaled_alone(options) && options.file.empty() != options.function.empty();
}

meshing::LogMetricField metric_of_share(Peers& peers, const MetricOptions& options, const MeshSlice& slice) {
  if (options.function.empty()) return metric_of_slice(peers, options.file, slice);
  meshing::MeshData points;
  points.points = slice.points;
  return meshing::sample(meshing::AnalyticMetric(options.function), points);
}

std::optional<SurfaceBound> surface_bound_in_parts(Peers& peers, const GeometryOptions& options,
                                                   const MeshSlice& slice) {
  const bool binds = options.limit_metric &&
                     (!options.model.empty() || partition::may_curve(peers, slice, options.ridge_angle));
  return binds ? std::optional(SurfaceBound{options.hausd, options.ridge_angle}) : std::nullopt;
}

LogMetricMade make_metric_in_parts(Peers& peers, const MetricOptions& options, const MeshSlice& slice,
                                   const std::string& mesh_name,
                                   const std::shared_ptr<const meshing::Model>& model,
                                   const std::optional<SurfaceBound>& bound,
                                   const std::atomic<bool>* interrupt) {
  const PartDomain domain = naming(mesh_name, [&] {
    const bool resolves = !options.sol.empty() || !options.solutions.empty();
    return PartDomain(peers, slice, resolves ? meshing::rings_of(options.recovery) : 1, interrupt);
  });
  MetricOptions here = options;
  for (Fields& solution : here.solutions) solution = of_part(domain, solution);
  std::optional<meshing::LogMetricField> source;
  const bool given = partition::max(peers, slice.log_metrics.empty() ? 0 : 1) != 0;
  if (given) source = domain.from_slices(slice.log_metrics);
  LogMetricMade made = make_log_metric(
      here,
      {domain, [&](const std::string& file) { return read_fields(peers, slice, domain, file); },
       [&](const std::string& file) { return domain.from_slices(metric_of_slice(peers, file, slice)); },
       [&] { return demand_in_part(peers, options, slice, domain, model); },
       [&]() -> std::optional<meshing::LogMetricField> {
         if (!bound) return std::nullopt;
         const meshing::CurvatureOptions curvature = bound->curvature(domain.largest_size());
         return partition::curvature_in_parts(peers, slice, domain, curvature, model);
       },
       source ? &*source : nullptr},
      mesh_name);
  made.field = domain.to_slices(made.field);
  return made;
}

}  // namespace weft::tools

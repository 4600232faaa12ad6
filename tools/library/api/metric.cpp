// Metrics, measures and fields: the interface over the kernel's functions.
#include <algorithm>
#include <string>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/fields/transfer.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_field.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/jobs/sources/model_source.h"
#include "weft/weft.h"

namespace weft {
namespace {

/// `source`: null where there is none.
MadeMetric make_of(const Mesh& mesh, const Metric* source, const MetricOptions& options,
                   const GeometryOptions& geometry, const std::string& name, int threads) {
  Options all;
  all.metric = options;
  all.geometry = geometry;
  all.run.threads = threads;
  validate(all);
  const WholeMesh whole(mesh);
  if (source) check_length(mesh, source->size(), "metric");
  tools::LogMetricMade made = tools::with_threads(tools::number_of_threads(threads), [&] {
    return tools::make_log_metric(options, *whole, name, source ? &source->logarithms() : nullptr,
                                  tools::model_of(geometry, *whole, name));
  });
  return {Metric::from_logarithms(std::move(made.field)), std::move(made.warnings)};
}

}  // namespace

Metric Metric::from_fields(const Fields& fields, std::size_t num_points, const std::string& file) {
  return from_logarithms(meshing::metric_from_solution(fields, num_points, file));
}

Metric Metric::from_tensors(std::span<const Tensor> tensors) {
  Field field{Field::Kind::tensor, {}, {}};
  field.values.reserve(6 * tensors.size());
  for (const Tensor& m : tensors)
    field.values.insert(field.values.end(), {m.xx, m.xy, m.yy, m.xz, m.yz, m.zz});
  return from_fields({tensors.size(), {std::move(field)}}, tensors.size(), "metric");
}

Metric Metric::from_sizes(std::span<const double> sizes) {
  Field field{Field::Kind::scalar, {sizes.begin(), sizes.end()}, {}};
  return from_fields({sizes.size(), {std::move(field)}}, sizes.size(), "metric");
}

Metric Metric::from_logarithms(std::vector<Tensor> logarithms) {
  Metric metric;
  metric.logarithms_ = std::move(logarithms);
  return metric;
}

Tensor Metric::tensor(std::size_t vertex) const { return meshing::exp_exact(logarithms_[vertex]); }

Fields Metric::fields() const { return meshing::solution_from_metric(logarithms_); }

MadeMetric make_metric(const Mesh& mesh, const MetricOptions& options, const std::string& name, int threads) {
  return make_metric(mesh, options, GeometryOptions(), name, threads);
}

MadeMetric make_metric(const Mesh& mesh, const MetricOptions& options, const GeometryOptions& geometry,
                       const std::string& name, int threads) {
  return make_of(mesh, nullptr, options, geometry, name, threads);
}

MadeMetric make_metric(const Mesh& mesh, const Metric& source, const MetricOptions& options,
                       const std::string& name, int threads) {
  return make_metric(mesh, source, options, GeometryOptions(), name, threads);
}

MadeMetric make_metric(const Mesh& mesh, const Metric& source, const MetricOptions& options,
                       const GeometryOptions& geometry, const std::string& name, int threads) {
  return make_of(mesh, &source, options, geometry, name, threads);
}

double complexity(const Mesh& mesh, const Metric& metric) {
  const WholeMesh whole(mesh);
  check_length(mesh, metric.size(), "metric");
  return meshing::complexity(*whole, metric.logarithms());
}

Measures measure(const Mesh& mesh, const Metric& metric) {
  const WholeMesh whole(mesh);
  check_length(mesh, metric.size(), "metric");
  return meshing::measure(*whole, metric.logarithms());
}

ShapeMeasures measure_shape(const Mesh& mesh) {
  const WholeMesh whole(mesh);
  return meshing::measure_shape(*whole);
}

Geometry measure_geometry(const Mesh& any) {
  const WholeMesh whole(any);
  const Mesh& mesh = *whole;
  Geometry g;
  g.shape = meshing::measure_shape(mesh);
  if (!mesh.points.empty()) g.min = g.max = mesh.points.front();
  for (const Point& p : mesh.points)
    for (int axis = 0; axis < 3; ++axis) {
      g.min[axis] = std::min(g.min[axis], p[axis]);
      g.max[axis] = std::max(g.max[axis], p[axis]);
    }
  const auto& p = mesh.points;
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    const auto& [a, b, c, d] = mesh.tets[i];
    g.volume_by_ref[mesh.tet_refs[i]] += meshing::six_volume(p[a], p[b], p[c], p[d]) / 6;
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    g.area_by_ref[mesh.triangle_refs[i]] += norm(cross(p[b] - p[a], p[c] - p[a])) / 2;
  }
  return g;
}

CheckReport verify(const Mesh& mesh, int max_problems) {
  const WholeMesh whole(mesh);
  return meshing::check_mesh(*whole, max_problems);
}

Transfer interpolate(const Mesh& from, const Fields& fields, const Mesh& to, TransferMethod method,
                     int threads, const std::string& from_name, const std::string& to_name) {
  const WholeMesh whole_from(from), whole_to(to);
  check_length(from, fields.num_points, "field");
  return tools::with_threads(tools::number_of_threads(threads), [&] {
    return tools::naming_meshes(from_name, to_name,
                                [&] { return meshing::transfer(*whole_from, fields, *whole_to, method); });
  });
}

}  // namespace weft

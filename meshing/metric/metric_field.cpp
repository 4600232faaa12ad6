// Building and processing metric fields: reading, scaling, limiting.
#include "meshing/metric/metric_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "meshing/base/assert.h"
#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/metric/metric_lanes.h"

namespace weft::meshing {
namespace {

// --- Fields of files
// -----------------------------------------------------------------------------------------

const Field& find_metric(const SolutionData& solution, const std::string& file) {
  for (const Field& field : solution.fields)
    if (field.kind != Field::Kind::vector) return field;
  throw InputError(file, "", "holds no scalar or tensor field, so no metric");
}

SymTensor tensor_at(const Field& field, std::size_t i) {
  const double* m = &field.values[6 * i];
  return {m[0], m[1], m[2], m[3], m[4], m[5]};
}

/// The same six numbers understood as m11 m12 m13 m22 m23 m33.
SymTensor row_wise_tensor_at(const Field& field, std::size_t i) {
  const double* m = &field.values[6 * i];
  return {m[0], m[1], m[3], m[2], m[4], m[5]};
}

bool all_finite(const Field& field, std::size_t i) {
  const int n = components(field.kind);
  return std::all_of(&field.values[n * i], &field.values[n * i] + n,
                     [](double v) { return std::isfinite(v); });
}

/// What eight at a time work on.
std::size_t number_of_batches(std::size_t n) { return (n + kLanes - 1) / kLanes; }
template <class T>
std::span<T> batch_of(std::span<T> all, std::size_t batch) {
  return all.subspan(kLanes * batch, std::min<std::size_t>(kLanes, all.size() - kLanes * batch));
}

/// Logarithms of the metrics of these sizes. Returns the first vertex whose size is none, or their number.
std::size_t take_sizes(const Field& field, LogMetricField& log_metrics) {
  const std::size_t bad = find_first(log_metrics.size(), [&](std::size_t i) {
    return !std::isfinite(field.values[i]) || !(field.values[i] > 0);
  });
  if (bad == log_metrics.size())
    for_each_index(bad,
                   [&](std::size_t i) { log_metrics[i] = identity_tensor(-2 * std::log(field.values[i])); });
  return bad;
}

/// The same of tensors. Those that are nearly singular are looked at one by one.
std::size_t take_tensors(const Field& field, LogMetricField& log_metrics) {
  const std::size_t bad = find_first(number_of_batches(log_metrics.size()), [&](std::size_t batch) {
    const std::span<LogMetric> logs = batch_of(std::span(log_metrics), batch);
    std::array<SymTensor, kLanes> metrics;
    for (std::size_t i = 0; i < logs.size(); ++i) metrics[i] = tensor_at(field, kLanes * batch + i);
    const unsigned left = logs_of(std::span(metrics).first(logs.size()), logs);
    for (std::size_t i = 0; i < logs.size(); ++i) {
      if (!(left >> i & 1)) continue;
      if (!all_finite(field, kLanes * batch + i) || !is_positive_definite(metrics[i])) return true;
      logs[i] = log_of(metrics[i]);
    }
    return false;
  });
  for (std::size_t i = kLanes * bad; i < log_metrics.size(); ++i)
    if (!all_finite(field, i) || !is_positive_definite(tensor_at(field, i))) return i;
  return log_metrics.size();
}

std::string reason_against(const Field& field, std::size_t i, std::size_t num_points) {
  if (!all_finite(field, i)) return "a value of the metric is not a finite number";
  if (field.kind == Field::Kind::scalar) return "the size is not positive (a solution is given by --sol)";
  const auto is_bad_row_wise = [&field](std::size_t k) {
    return !all_finite(field, k) || !is_positive_definite(row_wise_tensor_at(field, k));
  };
  const bool row_wise = find_first(num_points, is_bad_row_wise) == num_points;
  return row_wise ? "not positive definite (it would be in row-wise order m11 m12 m13 m22 m23 m33)"
                  : "not positive definite";
}

}  // namespace

LogMetricField metric_from_solution(const SolutionData& solution, std::size_t num_points,
                                    const std::string& file, std::uint64_t first) {
  if (solution.num_points != num_points)
    throw InputError(file, "",
                     "metric of another mesh: it has " + std::to_string(solution.num_points) +
                         " vertices, the mesh " + std::to_string(num_points));
  const Field& field = find_metric(solution, file);
  WEFT_ASSERT_LIGHT(field.values.size() == num_points * components(field.kind), "one value a vertex");
  LogMetricField log_metrics(num_points);
  const bool scalar = field.kind == Field::Kind::scalar;
  const std::size_t bad = scalar ? take_sizes(field, log_metrics) : take_tensors(field, log_metrics);
  if (bad < num_points)
    throw InputError(file, "vertex " + std::to_string(first + bad + 1),
                     reason_against(field, bad, num_points));
  return log_metrics;
}

SolutionData solution_from_metric(std::span<const LogMetric> log_metrics) {
  SolutionData solution{log_metrics.size(), {{Field::Kind::tensor, {}, "metric"}}};
  std::vector<double>& values = solution.fields[0].values;
  values.resize(6 * log_metrics.size());
  for_each_index(number_of_batches(log_metrics.size()), [&](std::size_t batch) {
    const std::span<const LogMetric> logs = batch_of(log_metrics, batch);
    std::array<Metric, kLanes> metrics;
    exps_of(logs, std::span(metrics).first(logs.size()));
    double* to = &values[6 * kLanes * batch];
    for (const Metric& m : std::span(metrics).first(logs.size()))
      to = std::ranges::copy(std::array{m.xx, m.xy, m.yy, m.xz, m.yz, m.zz}, to).out;
  });
  return solution;
}

double largest_size(const MeshData& mesh) {
  Box box;
  for (const Point& p : mesh.points) box.include(p);
  const double diagonal = mesh.points.empty() ? 0 : norm(box.size());
  return diagonal > 0 ? diagonal : 1;
}

LogMetricField sample(const AnalyticMetric& metric, const MeshData& mesh) {
  LogMetricField field(mesh.points.size());
  for_each_index(field.size(), [&](std::size_t i) { field[i] = log_of(metric(mesh.points[i])); });
  return field;
}

LogSizeLimits::LogSizeLimits(double hmin, double hmax)
    : lo(hmax > 0 ? -2 * std::log(hmax) : -std::numeric_limits<double>::infinity()),
      hi(hmin > 0 ? -2 * std::log(hmin) : std::numeric_limits<double>::infinity()) {
  if (lo > hi) throw InputError("", "hmin", "is larger than hmax");
}

void limit_sizes(double hmin, double hmax, LogMetricField& field) {
  const LogSizeLimits limits(hmin, hmax);
  if (limits.none()) return;
  for_each_index(field.size(), [&](std::size_t i) {
    Eigen3 e = eigen_decomposition(field[i]);
    if (limits(e.values[0]) == e.values[0] && limits(e.values[2]) == e.values[2]) return;
    for (double& v : e.values) v = limits(v);
    field[i] = from_eigen(e);
  });
}

void limit_aspect(double ratio, LogMetricField& field) {
  if (!(ratio >= 1)) return;
  const double most = 2 * std::log(ratio);
  for_each_index(field.size(), [&](std::size_t i) {
    Eigen3 e = eigen_decomposition(field[i]);
    if (e.values[2] - e.values[0] <= most) return;
    for (double& v : e.values) v = std::max(v, e.values[2] - most);
    field[i] = from_eigen(e);
  });
}

void intersect_with(const LogMetricField& other, LogMetricField& field) {
  WEFT_ASSERT_LIGHT(other.size() == field.size(), "one value a vertex");
  for_each_index(field.size(), [&](std::size_t i) {
    field[i] = log_of(intersect(exp_exact(field[i]), exp_exact(other[i])));
  });
}

}  // namespace weft::meshing

// Multiscale metrics from recovered Hessians.
#include "meshing/metric/sources/multiscale.h"

#include <algorithm>
#include <cmath>

#include "meshing/base/assert.h"
#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/mesh/adjacency.h"

namespace weft::meshing {
namespace {

/// What rounding may add to a value, against the largest of the field: a few units in the last place of what
/// solvers write with some digits lost.
constexpr double kRounding = 1e-12;

/// Least ratio of two eigenvalues of |H|: sizes up to 1:1e6. More would leave no digits in M's entries.
constexpr double kLeastRatio = 1e-12;

/// The second derivatives at each vertex that rounding alone can make in a field of magnitude 1.
std::vector<double> rounding_floors(const MeshData& mesh) {
  const VertexLists neighbours = vertex_neighbours(mesh.tets, mesh.points.size());
  std::vector<double> floors(mesh.points.size());
  for_each_index(floors.size(), [&](std::size_t v) {
    double longest2 = 0;
    for (const std::uint32_t w : neighbours.of(v))
      longest2 = std::max(longest2, norm2(mesh.points[w] - mesh.points[v]));
    floors[v] = 4 * kRounding / (longest2 > 0 ? longest2 : 1);
  });
  return floors;
}

/// `values` over the largest of them, so that no difference or derivative of extreme ones overflows.
std::vector<double> scaled_to_one(const MetricDomain& domain, std::span<const double> values) {
  double largest = 0;
  for (const double v : values) largest = std::max(largest, std::abs(v));
  largest = domain.max(largest);
  std::vector<double> scaled(values.begin(), values.end());
  if (largest > 0)
    for (double& v : scaled) v /= largest;
  return scaled;
}

LogMetric normalised(const SymTensor& hessian, double floor, double exponent) {
  Eigen3 e = eigen_decomposition(hessian);
  floor = std::max({floor, kLeastRatio * std::abs(e.values[0]), kLeastRatio * std::abs(e.values[2])});
  double log_determinant = 0;
  for (double& value : e.values) {
    value = std::log(std::max(std::abs(value), floor));
    log_determinant += value;
  }
  for (double& value : e.values) value += exponent * log_determinant;
  return from_eigen(e);
}

void check_finite(std::span<const double> values, const std::string& file, const std::string& field,
                  std::uint64_t first = 0) {
  const std::size_t bad = find_first(values.size(), [&](std::size_t v) { return !std::isfinite(values[v]); });
  if (bad < values.size())
    throw InputError(file, "vertex " + std::to_string(first + bad + 1),
                     "the value" + field + " is not a finite number");
}

}  // namespace

LogMetricField multiscale_metric(const MeshData& mesh, std::span<const double> values,
                                 const MultiscaleOptions& options) {
  return multiscale_metric(WholeDomain(mesh), values, options);
}

LogMetricField multiscale_metric(const MetricDomain& domain, std::span<const double> values,
                                 const MultiscaleOptions& options) {
  WEFT_ASSERT_LIGHT(values.size() == domain.mesh().points.size(), "one value a vertex");
  if (!(options.norm >= 1)) throw InputError("", "norm", "is below 1");
  check_finite(values, "", "");
  const std::vector<SymTensor> hessians =
      recover_hessians(domain, scaled_to_one(domain, values), options.recovery);
  const std::vector<double> floors = rounding_floors(domain.mesh());
  LogMetricField field(hessians.size());
  const double exponent = -1 / (2 * options.norm + 3);
  for_each_index(field.size(),
                 [&](std::size_t v) { field[v] = normalised(hessians[v], floors[v], exponent); });
  domain.refresh(field);  // floors need all neighbours
  return field;
}

std::vector<std::span<const double>> scalar_fields(const SolutionData& solution, std::size_t num_points,
                                                   const std::string& file, std::uint64_t first) {
  if (solution.num_points != num_points)
    throw InputError(file, "",
                     "solution of another mesh: it has " + std::to_string(solution.num_points) +
                         " vertices, the mesh " + std::to_string(num_points));
  std::vector<std::span<const double>> scalars;
  for (std::size_t i = 0; i < solution.fields.size(); ++i) {
    const Field& field = solution.fields[i];
    if (field.kind != Field::Kind::scalar) continue;
    check_finite(field.values, file, " of field " + std::to_string(i + 1), first);
    scalars.emplace_back(field.values);
  }
  if (scalars.empty()) throw InputError(file, "", "holds no scalar field to take a metric from");
  return scalars;
}

}  // namespace weft::meshing

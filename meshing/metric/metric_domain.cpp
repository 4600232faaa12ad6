// Sums over a whole mesh, and the scaling of metrics to a complexity on any domain.
#include "meshing/metric/metric_domain.h"

#include <tbb/parallel_reduce.h>

#include <array>
#include <cmath>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/metric/measures.h"

namespace weft::meshing {
namespace {

/// The complexity of limit_sizes(exp(shift) M) as a function of shift, which is monotone.
class LimitedComplexity {
 public:
  LimitedComplexity(const MetricDomain& domain, const LogSizeLimits& limits, const LogMetricField& field)
      : domain_(domain), limits_(limits), field_(field), volumes_(vertex_volumes(domain.mesh())) {
    if (limits.none()) return;
    log_values_.resize(field.size());
    for_each_index(field.size(),
                   [&](std::size_t i) { log_values_[i] = eigen_decomposition(field[i]).values; });
  }
  double operator()(double shift) const {
    return domain_.sum([&](std::size_t i) { return density(i, shift) * volumes_[i]; });
  }

 private:
  double density(std::size_t i, double shift) const {
    if (limits_.none()) return std::exp(0.5 * (trace(field_[i]) + 3 * shift));
    double log_det = 0;
    for (const double v : log_values_[i]) log_det += limits_(v + shift);
    return std::exp(0.5 * log_det);
  }

  const MetricDomain& domain_;
  LogSizeLimits limits_;
  const LogMetricField& field_;
  std::vector<double> volumes_;
  std::vector<std::array<double, 3>> log_values_;  ///< empty without limits
};

void check_scalable(double complexity, double target) {
  if (!(complexity > 0))
    throw InputError("", "complexity", "cannot be scaled: the mesh has no volume, or inverted tets");
  if (!(target > 0)) throw InputError("", "complexity", "the target is not positive");
}

/// Solves complexity(shift) = target. The unlimited law C ~ exp(3/2 shift) gives the steps; bisection takes
/// over where limits slow them down, and ends at an end of the bracket where they forbid the target.
double solve_shift(const LimitedComplexity& complexity_at, double target) {
  double lo = -100, hi = 100;  // sizes changed by e^50 at most
  double shift = 0;
  for (int step = 0; step < 60; ++step) {
    const double c = complexity_at(shift);
    if (std::abs(c - target) <= 1e-9 * target) break;
    (c < target ? lo : hi) = shift;
    const double next = shift + 2.0 / 3.0 * std::log(target / c);
    shift = step < 6 && next > lo && next < hi ? next : 0.5 * (lo + hi);
  }
  return shift;
}

void shift_by(double log_factor, LogMetricField& field) {
  const LogMetric shift = identity_tensor(log_factor);
  for_each_index(field.size(), [&](std::size_t i) { field[i] = field[i] + shift; });
}

}  // namespace

double WholeDomain::sum(const std::function<double(std::size_t)>& at) const {
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, mesh_.points.size(), 4096), 0.0,
      [&](const auto& range, double sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) sum += at(i);
        return sum;
      },
      std::plus<>());
}

double WholeDomain::complexity(const LogMetricField& field) const {
  return meshing::complexity(mesh_, field);
}

std::vector<double> vertex_volumes(const MeshData& mesh) {
  std::vector<double> volumes(mesh.points.size(), 0);
  for (const auto& [a, b, c, d] : mesh.tets) {
    const auto& p = mesh.points;
    const double quarter = six_volume(p[a], p[b], p[c], p[d]) / 24;
    for (const std::uint32_t v : {a, b, c, d}) volumes[v] += quarter;
  }
  return volumes;
}

void scale_to_complexity(const MetricDomain& domain, double target, LogMetricField& field) {
  const double now = domain.complexity(field);
  check_scalable(now, target);
  shift_by(2.0 / 3.0 * std::log(target / now), field);
}

double scale_to_complexity(const MetricDomain& domain, double target, double hmin, double hmax,
                           LogMetricField& field) {
  const LimitedComplexity complexity_at(domain, LogSizeLimits(hmin, hmax), field);
  check_scalable(complexity_at(0), target);
  shift_by(solve_shift(complexity_at, target), field);
  limit_sizes(hmin, hmax, field);
  return domain.complexity(field);
}

void scale_to_complexity(const MeshData& mesh, double target, LogMetricField& field) {
  scale_to_complexity(WholeDomain(mesh), target, field);
}

double scale_to_complexity(const MeshData& mesh, double target, double hmin, double hmax,
                           LogMetricField& field) {
  return scale_to_complexity(WholeDomain(mesh), target, hmin, hmax, field);
}

}  // namespace weft::meshing

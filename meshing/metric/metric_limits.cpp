// Limits of metric fields, and the search for the scale at which the complexity is right under them.
#include "meshing/metric/metric_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/metric/metric_domain.h"

namespace weft::meshing {
namespace {

/// Applies one set of limits to many fields on the same mesh.
class Limiter {
 public:
  Limiter(const MetricDomain& domain, const MetricLimits& limits)
      : limits_(limits), gradation_(domain, limits.gradation, limits.space) {}

  void operator()(LogMetricField& field) const {
    clamp(field);
    if (gradation_.limit(field) > 0) clamp(field);
  }

 private:
  void clamp(LogMetricField& field) const {
    limit_aspect(limits_.aspect, field);
    if (limits_.hmin > 0 || limits_.hmax > 0) limit_sizes(limits_.hmin, limits_.hmax, field);
  }

  MetricLimits limits_;
  Gradation gradation_;
};

/// The root of an increasing function known by trials: secants, halving the bracket where they leave it.
class RootSearch {
 public:
  double x() const { return x_; }
  /// True when a long step changed next to nothing: there is no root.
  bool stalled() const { return stalled_; }
  /// Takes y = f(x()) and moves x() on.
  void step(double y) {
    if (has_last_) learn_slope(x_ - last_x_, y - last_y_, y);
    has_last_ = true;
    last_x_ = x_, last_y_ = y;
    (y < 0 ? lo_ : hi_) = x_;
    x_ -= y / slope_;
    if (!(x_ > lo_ && x_ < hi_)) x_ = 0.5 * (lo_ + hi_);
  }

 private:
  void learn_slope(double dx, double dy, double y) {
    stalled_ = std::abs(dx) > 1 && std::abs(dy) < 1e-3 * std::abs(y);
    slope_ = std::clamp(dy / dx, kLeast, kMost);
  }

  // f is the logarithm of the complexity against that of the metric's factor: its slope is 3/2 where nothing
  // limits it, and a little below 1 under a gradation of 1.5, the less the coarser the metric.
  static constexpr double kLeast = 0.05, kMost = 1.5;
  double x_ = 0, slope_ = 0.95;
  double lo_ = -200, hi_ = 200;  // sizes changed by e^100 at most
  bool has_last_ = false, stalled_ = false;
  double last_x_ = 0, last_y_ = 0;
};

/// Complexities nearer to each other than this are the same.
constexpr double kComplexityTolerance = 5e-4;
/// From here on the search goes on from its last field: where that is to become finer, which keeps it graded
/// (sizes shrink, so that edges grow longer and allow more), and where it is to become a little coarser.
constexpr double kNearBelow = -5e-2, kNearAbove = 1e-2;
/// The scale, as a logarithm, at which nothing of the metric is left but limits and demands: sizes change by
/// e^50.
constexpr double kOutOfReach = 100;

/// The complexities between which limits and demands keep every scale of a metric: of the coarsest field that
/// they allow before gradation, and of the finest.
struct Reach {
  double least = 0, most = std::numeric_limits<double>::infinity();
};
Reach reach_of(const MetricDomain& domain, const MetricLimits& limits, const LogMetricField* demands) {
  Reach reach;
  const auto uniform = [&](double h) {
    return domain.complexity(LogMetricField(domain.mesh().points.size(), identity_tensor(-2 * std::log(h))));
  };
  if (limits.hmin > 0) reach.most = uniform(limits.hmin);
  if (limits.hmax > 0) reach.least = uniform(limits.hmax);
  if (demands) {
    LogMetricField coarsest = *demands;
    if (limits.hmin > 0 || limits.hmax > 0) limit_sizes(limits.hmin, limits.hmax, coarsest);
    reach.least = domain.complexity(coarsest);
  }
  return reach;
}

}  // namespace

void apply_limits(const MetricDomain& domain, const MetricLimits& limits, LogMetricField& field) {
  Limiter(domain, limits)(field);
}

double fit_to_complexity(const MetricDomain& domain, double target, const MetricLimits& limits,
                         const LogMetricField* demands, LogMetricField& field) {
  constexpr int kMostTrials = 30;
  scale_to_complexity(domain, target,
                      field);  // a good start where limits change little; checks its arguments
  const LogMetricField wanted = field;
  const Limiter limit(domain, limits);
  const auto reached_at = [&](const LogMetricField& start, double x) {
    const LogMetric shift = identity_tensor(x);
    for_each_index(field.size(), [&](std::size_t v) { field[v] = start[v] + shift; });
    if (demands) intersect_with(*demands, field);
    limit(field);
    return domain.complexity(field);
  };
  const Reach reach = reach_of(domain, limits, demands);
  if (target < reach.least * (1 - kComplexityTolerance)) return reached_at(wanted, -kOutOfReach);
  if (target > reach.most * (1 + kComplexityTolerance)) return reached_at(wanted, kOutOfReach);
  RootSearch search;
  double reached = 0, last_x = 0, error = std::numeric_limits<double>::infinity();
  for (int trial = 0; trial < kMostTrials && !search.stalled(); ++trial) {
    // From the field as it was: scaling down one that is graded already by much and grading it again was no
    // faster, and left it finer than need be. The last little step saves most of a gradation and changes
    // sizes by less than the gradation's own tolerance.
    const bool near = error > kNearBelow && error < kNearAbove;
    reached = near ? reached_at(field, search.x() - last_x) : reached_at(wanted, search.x());
    if (domain.interrupted()) break;
    error = std::log(reached / target);
    if (std::abs(error) < kComplexityTolerance) break;
    last_x = search.x();
    search.step(error);
  }
  return reached;
}

void apply_limits(const MeshData& mesh, const MetricLimits& limits, LogMetricField& field) {
  apply_limits(WholeDomain(mesh), limits, field);
}

double fit_to_complexity(const MeshData& mesh, double target, const MetricLimits& limits,
                         const LogMetricField* demands, LogMetricField& field) {
  return fit_to_complexity(WholeDomain(mesh), target, limits, demands, field);
}

}  // namespace weft::meshing

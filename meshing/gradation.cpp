// Sweeps of gradation over a metric field.
#include "meshing/gradation.h"

#include <atomic>
#include <cassert>
#include <cmath>
#include <vector>

#include "meshing/parallel.h"

namespace weft::meshing {
namespace {

constexpr int kMaxSweeps = 50;
constexpr double kTolerance = 1e-3;

/// Positive definite by its Cholesky factors: backward stable, where minors by expansion drown in rounding at
/// anisotropies of 1:1e5; much cheaper than eigenvalues.
bool has_cholesky_factors(const SymTensor& a) {
  if (!(a.xx > 0)) return false;
  const double l21 = a.xy / a.xx, l31 = a.xz / a.xx;
  const double d2 = a.yy - l21 * a.xy;
  if (!(d2 > 0)) return false;
  const double yz = a.yz - l31 * a.xy;
  return a.zz - l31 * a.xz - yz / d2 * yz > 0;
}

/// M_p grown along an edge that leaves p.
class MetricSpaceGrowth {
 public:
  MetricSpaceGrowth(double beta, std::size_t) : log_beta_(std::log(beta)) {}
  void update(std::size_t, const Metric&) {}
  Metric operator()(std::size_t, const Metric& at_p, const Vec& edge) const {
    const double growth = 1 + std::sqrt(squared_length(at_p, edge)) * log_beta_;
    return (1 / (growth * growth)) * at_p;
  }

 private:
  double log_beta_;
};

class MixedSpaceGrowth {
 public:
  MixedSpaceGrowth(double beta, std::size_t size) : log_beta_(std::log(beta)), eigen_(size) {}
  void update(std::size_t p, const Metric& at_p) { eigen_[p] = eigen_decomposition(at_p); }
  Metric operator()(std::size_t p, const Metric& at_p, const Vec& edge) const {
    const double in_metric = 1 + std::sqrt(squared_length(at_p, edge)) * log_beta_;
    const double distance = norm(edge);
    Eigen3 grown = eigen_[p];
    for (double& value : grown.values) {
      const double in_space = 1 + std::sqrt(value) * distance * log_beta_;
      // The eighth root: t = 1/8.
      const double growth = in_metric * std::sqrt(std::sqrt(std::sqrt(in_space / in_metric)));
      value /= growth * growth;
    }
    return from_eigen(grown);
  }

 private:
  double log_beta_;
  std::vector<Eigen3> eigen_;  ///< of every metric: an edge would need it 14 times a vertex
};

/// The metrics of one field while they are graded.
template <class Growth>
class Grading {
 public:
  Grading(const MeshData& mesh, const VertexLists& neighbours, Growth growth, std::vector<Metric>& metrics)
      : mesh_(mesh),
        neighbours_(neighbours),
        growth_(std::move(growth)),
        metrics_(metrics),
        changed_(metrics.size(), 1),
        ever_changed_(metrics.size(), 0) {}

  /// True when some metric changed. Only neighbours that changed in the last sweep can demand anything new,
  /// because metrics never become smaller.
  bool sweep() {
    for_each_index(metrics_.size(), [&](std::size_t p) {
      if (changed_[p]) growth_.update(p, metrics_[p]);
    });
    std::vector<Metric> next = metrics_;
    std::vector<std::uint8_t> changed(metrics_.size(), 0);
    std::atomic<bool> any = false;
    for_each_index(metrics_.size(), [&](std::size_t q) {
      for (const std::uint32_t p : neighbours_.of(q))
        if (changed_[p] && limit(p, mesh_.points[q] - mesh_.points[p], next[q])) changed[q] = 1;
      if (!changed[q]) return;
      ever_changed_[q] = 1;
      any.store(true, std::memory_order_relaxed);
    });
    metrics_.swap(next);
    changed_.swap(changed);
    return any;
  }
  bool ever_changed(std::size_t v) const { return ever_changed_[v]; }

 private:
  bool limit(std::uint32_t p, const Vec& edge, Metric& at_q) const {
    const Metric demanded = growth_(p, metrics_[p], edge);
    if (has_cholesky_factors((1 + kTolerance) * at_q - demanded)) return false;
    at_q = intersect(at_q, demanded);
    return true;
  }

  const MeshData& mesh_;
  const VertexLists& neighbours_;
  Growth growth_;
  std::vector<Metric>& metrics_;
  std::vector<std::uint8_t> changed_, ever_changed_;
};

template <class Growth>
int grade(const MeshData& mesh, const VertexLists& neighbours, double beta, LogMetricField& field) {
  std::vector<Metric> metrics(field.size());
  for_each_index(field.size(), [&](std::size_t i) { metrics[i] = exp_exact(field[i]); });
  Grading<Growth> grading(mesh, neighbours, Growth(beta, field.size()), metrics);
  int sweeps = 0;
  while (sweeps < kMaxSweeps && grading.sweep()) ++sweeps;
  for_each_index(field.size(), [&](std::size_t i) {
    if (grading.ever_changed(i)) field[i] = log_of(metrics[i]);
  });
  return sweeps;
}

}  // namespace

Gradation::Gradation(const MeshData& mesh, double beta, GradationSpace space)
    : mesh_(mesh), beta_(beta), space_(space) {
  if (beta > 1) neighbours_ = vertex_neighbours(mesh.tets, mesh.points.size());
}

int Gradation::limit(LogMetricField& field) const {
  assert(field.size() == mesh_.points.size());
  if (!(beta_ > 1)) return 0;
  return space_ == GradationSpace::metric ? grade<MetricSpaceGrowth>(mesh_, neighbours_, beta_, field)
                                          : grade<MixedSpaceGrowth>(mesh_, neighbours_, beta_, field);
}

int limit_gradation(const MeshData& mesh, double beta, LogMetricField& field, GradationSpace space) {
  return Gradation(mesh, beta, space).limit(field);
}

}  // namespace weft::meshing

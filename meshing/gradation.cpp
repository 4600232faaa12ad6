// Sweeps of gradation over a metric field.
#include "meshing/gradation.h"

#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
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
        state_(metrics.size(), kChanged),
        changed_(metrics.size()) {
    std::iota(changed_.begin(), changed_.end(), 0u);
  }

  /// True when some metric changed. Only neighbours that changed in the last sweep can demand anything new,
  /// because metrics never become smaller; most sweeps are over a front of few vertices.
  bool sweep() {
    for_each_index(changed_.size(),
                   [&](std::size_t i) { growth_.update(changed_[i], metrics_[changed_[i]]); });
    const std::vector<std::uint32_t> candidates = beside_changed();
    // All from the state before the sweep: the new metrics take their places only after it.
    std::vector<Metric> next(candidates.size());
    std::vector<std::uint8_t> changes(candidates.size());
    for_each_index(candidates.size(), [&](std::size_t i) {
      const std::uint32_t q = candidates[i];
      next[i] = metrics_[q];
      for (const std::uint32_t p : neighbours_.of(q))
        if (state_[p] & kChanged && limit(p, mesh_.points[q] - mesh_.points[p], next[i])) changes[i] = 1;
    });
    for (const std::uint32_t p : changed_) state_[p] &= kEverChanged;
    changed_.clear();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      state_[candidates[i]] &= static_cast<std::uint8_t>(~kCandidate);
      if (!changes[i]) continue;
      metrics_[candidates[i]] = next[i];
      state_[candidates[i]] |= kChanged | kEverChanged;
      changed_.push_back(candidates[i]);
    }
    return !changed_.empty();
  }
  bool ever_changed(std::size_t v) const { return state_[v] & kEverChanged; }

 private:
  static constexpr std::uint8_t kChanged = 1, kEverChanged = 2, kCandidate = 4;

  /// All neighbours of the vertices that changed last, once each.
  std::vector<std::uint32_t> beside_changed() {
    std::vector<std::uint32_t> candidates;
    if (changed_.size() == metrics_.size()) return changed_;
    for (const std::uint32_t p : changed_)
      for (const std::uint32_t q : neighbours_.of(p)) {
        if (state_[q] & kCandidate) continue;
        state_[q] |= kCandidate;
        candidates.push_back(q);
      }
    return candidates;
  }

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
  std::vector<std::uint8_t> state_;
  std::vector<std::uint32_t> changed_;  ///< in the last sweep; before the first one all count as such
};

template <class Growth>
int grade(const MeshData& mesh, const VertexLists& neighbours, double beta, LogMetricField& field) {
  std::vector<Metric> metrics(field.size());
  for_each_index(field.size(), [&](std::size_t i) { metrics[i] = exp_fast(field[i]); });
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

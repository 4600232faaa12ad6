// Sweeps of gradation over a metric field.
#include "meshing/metric/gradation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "meshing/base/assert.h"
#include "meshing/base/lanes.h"
#include "meshing/base/parallel.h"

namespace weft::meshing {
namespace {

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

/// Up to eight neighbours p of a vertex q: their metrics, which then become their demands on that of q.
class Batch {
 public:
  int size() const { return size_; }
  void clear() { size_ = 0; }
  void add(std::uint32_t p, const Metric& at_p, const Vec& edge) {
    ids_[size_] = p;
    for (int i = 0; i < 3; ++i) edges_[i * kLanes + size_] = edge[i];
    set_metric(size_++, at_p);
  }
  std::uint32_t id(int i) const { return ids_[i]; }
  VecLanes edges() const { return load_lanes3(edges_, kLanes); }
  Vec edge(int i) const { return {edges_[i], edges_[kLanes + i], edges_[2 * kLanes + i]}; }
  TensorLanes metrics() const { return load_lanes6(metrics_, kLanes); }
  Metric metric(int i) const {
    const double* m = metrics_ + i;
    return {m[0], m[kLanes], m[2 * kLanes], m[3 * kLanes], m[4 * kLanes], m[5 * kLanes]};
  }
  void set_metric(int i, const Metric& m) {
    const double entries[6] = {m.xx, m.xy, m.yy, m.xz, m.yz, m.zz};
    for (int k = 0; k < 6; ++k) metrics_[k * kLanes + i] = entries[k];
  }
  void scale_metrics(const Lanes& factor) {
    for (int k = 0; k < 6; ++k)
      store_lanes(metrics_ + k * kLanes, factor * load_lanes(metrics_ + k * kLanes));
  }

 private:
  int size_ = 0;
  std::uint32_t ids_[kLanes];
  alignas(sizeof(Lanes)) double edges_[3 * kLanes] = {};
  alignas(sizeof(Lanes)) double metrics_[6 * kLanes] = {};
};

/// Bit i set: demand i is not met by `at_q` by more than the tolerance. has_cholesky_factors, eight at once.
unsigned unmet(const Metric& at_q, const Batch& demands) {
  const Metric bound = (1 + kTolerance) * at_q;
  const TensorLanes d = demands.metrics();
  const TensorLanes a = {bound.xx - d.xx, bound.xy - d.xy, bound.yy - d.yy,
                         bound.xz - d.xz, bound.yz - d.yz, bound.zz - d.zz};
  const Lanes l21 = a.xy / a.xx, l31 = a.xz / a.xx;
  const Lanes d2 = a.yy - l21 * a.xy, yz = a.yz - l31 * a.xy;
  const Lanes d3 = a.zz - l31 * a.xz - yz / d2 * yz;
  const auto met = (a.xx > 0) & (d2 > 0) & (d3 > 0);
  // Copied, because GCC 12's sanitizer for undefined behaviour reads wrong lanes of a mask.
  std::array<std::int64_t, kLanes> is_met;
  static_assert(sizeof is_met == sizeof met);
  std::memcpy(is_met.data(), &met, sizeof met);
  unsigned bits = 0;
  for (int i = 0; i < demands.size(); ++i) bits |= (is_met[i] != 0 ? 0u : 1u) << i;
  return bits;
}

/// M_p grown along an edge that leaves p.
class MetricSpaceGrowth {
 public:
  MetricSpaceGrowth(double beta, std::size_t) : log_beta_(std::log(beta)) {}
  void update(std::size_t, const Metric&) {}
  void operator()(Batch& batch) const {
    const auto [x, y, z] = batch.edges();
    const TensorLanes m = batch.metrics();
    const Lanes length2 = x * (m.xx * x + m.xy * y + m.xz * z) + y * (m.xy * x + m.yy * y + m.yz * z) +
                          z * (m.xz * x + m.yz * y + m.zz * z);
    Lanes length{};
    for (int i = 0; i < kLanes; ++i) length[i] = std::sqrt(length2[i]);
    const Lanes growth = 1 + length * log_beta_;
    batch.scale_metrics(1 / (growth * growth));
  }

 private:
  double log_beta_;
};

class MixedSpaceGrowth {
 public:
  MixedSpaceGrowth(double beta, std::size_t size) : log_beta_(std::log(beta)), eigen_(size) {}
  void update(std::size_t p, const Metric& at_p) { eigen_[p] = eigen_decomposition(at_p); }
  void operator()(Batch& batch) const {
    for (int i = 0; i < batch.size(); ++i)
      batch.set_metric(i, grown(eigen_[batch.id(i)], batch.metric(i), batch.edge(i)));
  }

 private:
  Metric grown(Eigen3 eigen, const Metric& at_p, const Vec& edge) const {
    const double in_metric = 1 + std::sqrt(squared_length(at_p, edge)) * log_beta_;
    const double distance = norm(edge);
    for (double& value : eigen.values) {
      const double in_space = 1 + std::sqrt(value) * distance * log_beta_;
      // The eighth root: t = 1/8.
      const double growth = in_metric * std::sqrt(std::sqrt(std::sqrt(in_space / in_metric)));
      value /= growth * growth;
    }
    return from_eigen(eigen);
  }

  double log_beta_;
  std::vector<Eigen3> eigen_;  ///< of every metric: an edge would need it 14 times a vertex
};

/// The metrics of one field while they are graded.
template <class Growth>
class Grading {
 public:
  Grading(const MetricDomain& domain, const VertexLists& neighbours, Growth growth,
          std::vector<Metric>& metrics)
      : domain_(domain),
        points_(domain.mesh().points),
        neighbours_(neighbours),
        growth_(std::move(growth)),
        metrics_(metrics),
        state_(metrics.size(), kChanged),
        changed_(metrics.size()) {
    std::iota(changed_.begin(), changed_.end(), 0u);
  }

  /// Of parts the greatest counts: whose flag is set ends the sweeps of all.
  enum class Outcome : std::uint8_t { graded, changed, interrupted };

  /// Only neighbours that changed in the last sweep can demand anything new, because metrics never become
  /// smaller; most sweeps are over a front of few vertices.
  Outcome sweep() {
    for_each_index(changed_.size(),
                   [&](std::size_t i) { growth_.update(changed_[i], metrics_[changed_[i]]); });
    const std::vector<std::uint32_t> candidates = beside_changed();
    // All from the state before the sweep: the new metrics take their places only after it.
    next_.resize(std::max(next_.size(), candidates.size()));
    changes_.assign(candidates.size(), 0);
    for_each_index(candidates.size(), [&](std::size_t i) {
      const std::uint32_t q = candidates[i];
      next_[i] = metrics_[q];
      Batch batch;
      for (const std::uint32_t p : neighbours_.of(q)) {
        if (!(state_[p] & kChanged)) continue;
        batch.add(p, metrics_[p], points_[q] - points_[p]);
        if (batch.size() == kLanes) changes_[i] |= meet(batch, next_[i]);
      }
      if (batch.size() > 0) changes_[i] |= meet(batch, next_[i]);
    });
    for (const std::uint32_t p : changed_) state_[p] &= kEverChanged;
    changed_.clear();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      state_[candidates[i]] &= static_cast<std::uint8_t>(~kCandidate);
      if (!changes_[i]) continue;
      metrics_[candidates[i]] = next_[i];
      state_[candidates[i]] |= kChanged | kEverChanged;
      changed_.push_back(candidates[i]);
    }
    for (const std::uint32_t v : domain_.refresh_changed(changed_, metrics_)) {
      state_[v] |= kChanged | kEverChanged;
      changed_.push_back(v);
    }
    const Outcome here = domain_.interrupted_here() ? Outcome::interrupted
                         : changed_.empty()         ? Outcome::graded
                                                    : Outcome::changed;
    return static_cast<Outcome>(domain_.max(static_cast<double>(here)));
  }
  bool ever_changed(std::size_t v) const { return state_[v] & kEverChanged; }

 private:
  static constexpr std::uint8_t kChanged = 1, kEverChanged = 2, kCandidate = 4;

  /// All owned neighbours of the vertices that changed last, once each.
  std::vector<std::uint32_t> beside_changed() {
    std::vector<std::uint32_t> candidates;
    if (changed_.size() == metrics_.size()) {
      std::ranges::copy_if(changed_, std::back_inserter(candidates),
                           [&](std::uint32_t v) { return domain_.owns(v); });
      return candidates;
    }
    for (const std::uint32_t p : changed_)
      for (const std::uint32_t q : neighbours_.of(p)) {
        if (state_[q] & kCandidate || !domain_.owns(q)) continue;
        state_[q] |= kCandidate;
        candidates.push_back(q);
      }
    return candidates;
  }

  /// Intersects the metric with what the batch demands, and clears the batch. True when that changed it.
  bool meet(Batch& batch, Metric& at_q) const {
    growth_(batch);
    bool changed = false;
    for (unsigned bits = unmet(at_q, batch); bits != 0; bits &= bits - 1) {
      const Metric demanded = batch.metric(std::countr_zero(bits));
      // The ones before may have met this one too.
      if (changed && has_cholesky_factors((1 + kTolerance) * at_q - demanded)) continue;
      at_q = intersect(at_q, demanded);
      changed = true;
    }
    batch.clear();
    return changed;
  }

  const MetricDomain& domain_;
  const std::vector<Point>& points_;
  const VertexLists& neighbours_;
  Growth growth_;
  std::vector<Metric>& metrics_;
  std::vector<std::uint8_t> state_;
  std::vector<std::uint32_t> changed_;  ///< in the last sweep; before the first one all count as such
  std::vector<Metric> next_;            ///< what becomes of the candidates of a sweep
  std::vector<std::uint8_t> changes_;   ///< whether it is something new
};

template <class Growth>
int grade(const MetricDomain& domain, const VertexLists& neighbours, double beta, LogMetricField& field) {
  std::vector<Metric> metrics(field.size());
  for_each_index(field.size(), [&](std::size_t i) { metrics[i] = exp_fast(field[i]); });
  Grading<Growth> grading(domain, neighbours, Growth(beta, field.size()), metrics);
  // A demand travels one edge a sweep and weakens on the way, so that none passes a vertex twice (Bellman and
  // Ford's argument, exact for isotropic sizes). Intersections of anisotropic ones may need a few more.
  const std::size_t most = domain.num_points() + 50;
  using Outcome = typename Grading<Growth>::Outcome;
  int sweeps = 0;
  for (auto last = Outcome::changed; last == Outcome::changed && static_cast<std::size_t>(sweeps) < most;) {
    last = grading.sweep();
    if (last != Outcome::graded) ++sweeps;
  }
  for_each_index(field.size(), [&](std::size_t i) {
    if (grading.ever_changed(i)) field[i] = log_of(metrics[i]);
  });
  return sweeps;
}

}  // namespace

Gradation::Gradation(const MetricDomain& domain, double beta, GradationSpace space)
    : domain_(domain), beta_(beta), space_(space) {
  if (beta > 1) neighbours_ = vertex_neighbours(domain.mesh().tets, domain.mesh().points.size());
}

int Gradation::limit(LogMetricField& field) const {
  WEFT_ASSERT_LIGHT(field.size() == domain_.mesh().points.size(), "one metric a vertex");
  if (!(beta_ > 1)) return 0;
  return space_ == GradationSpace::metric ? grade<MetricSpaceGrowth>(domain_, neighbours_, beta_, field)
                                          : grade<MixedSpaceGrowth>(domain_, neighbours_, beta_, field);
}

int limit_gradation(const MeshData& mesh, double beta, LogMetricField& field, GradationSpace space) {
  const WholeDomain domain(mesh);
  return Gradation(domain, beta, space).limit(field);
}

}  // namespace weft::meshing

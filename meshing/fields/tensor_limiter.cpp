// Fluxes along edges, reduced vertex by vertex until every tensor keeps its bounds; the congruence.
#include "meshing/fields/tensor_limiter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {
namespace {

SymTensor tensor_at(std::span<const double> values, std::size_t at) {
  const double* t = values.data() + at;
  return {t[0], t[1], t[2], t[3], t[4], t[5]};
}

class TensorLimiter {
 public:
  TensorLimiter(const MetricDomain& domain, const MassMatrix& mass, const TensorColumns& columns,
                std::span<const double> loads, std::span<const double> lo, std::span<const double> hi,
                const ValueTable& table)
      : domain_(domain),
        mass_(mass),
        columns_(columns),
        loads_(loads),
        lo_(lo),
        hi_(hi),
        table_(table),
        share_(mass.lumped().size(), 1),
        limited_(share_.size()) {}

  /// The tensors of all vertices; those of vertices without tets are as they were.
  const std::vector<SymTensor>& run() {
    update_all();
    for (int pass = 0; pass < kMostPasses && reduce_shares(pass); ++pass) update_all();
    return limited_;
  }

 private:
  static constexpr double kLeastShare = 1.0 / 64;
  static constexpr int kHalvings = 50, kMostPasses = 100;
  std::size_t at(std::size_t v, std::size_t column) const { return v * table_.columns + column; }
  SymTensor consistent(std::size_t v) const { return tensor_at(table_.values, at(v, columns_.first)); }

  void update_all() {
    for_each_index(limited_.size(), [&](std::size_t v) { limited_[v] = with_fluxes(v); });
  }

  SymTensor with_fluxes(std::size_t v) const {
    const SymTensor mine = consistent(v);
    const double lumped = mass_.lumped()[v];
    if (!(lumped > 0)) return mine;
    SymTensor sum = tensor_at(loads_, at(v, columns_.first));
    mass_.for_each_in_row(v, [&](std::uint32_t w, double entry) {
      sum = sum + std::min(share_[v], share_[w]) * entry * (mine - consistent(w));
    });
    return (1 / lumped) * sum;
  }

  /// Bounds are those of old values: what rounding adds must not count.
  bool is_within(std::size_t v) const {
    constexpr double kRounding = 1e-12;
    const Eigen3 e = eigen_decomposition(limited_[v]);
    const double least = lo_[at(v, columns_.least)], largest = hi_[at(v, columns_.largest)];
    return e.values[0] > 0 && e.values[0] >= least - kRounding * largest &&
           e.values[2] <= (1 + kRounding) * largest;
  }

  /// Halves the shares of the vertices out of bounds, down to none, where the tensor is the lumped one; false
  /// when there was nothing to do. A vertex that is brought back may send a neighbour out, and so on along a
  /// chain: after kHalvings passes the shares are dropped at once, and in the last pass those of all
  /// vertices.
  bool reduce_shares(int pass) {
    std::vector<std::uint8_t> reduced(share_.size(), 0);
    for_each_index(share_.size(), [&](std::size_t v) {
      if (domain_.owns(v) && share_[v] > 0 && mass_.lumped()[v] > 0 && !is_within(v)) reduced[v] = 1;
    });
    for (std::size_t v = 0; v < share_.size(); ++v)
      if (reduced[v]) share_[v] = pass < kHalvings && share_[v] > kLeastShare ? share_[v] / 2 : 0;
    const bool any = domain_.any(std::ranges::find(reduced, 1) != reduced.end());
    domain_.refresh(1, share_);
    if (any && pass + 1 == kMostPasses) std::ranges::fill(share_, 0.0);
    return any;
  }

  const MetricDomain& domain_;
  const MassMatrix& mass_;
  const TensorColumns columns_;
  std::span<const double> loads_, lo_, hi_;
  const ValueTable& table_;
  std::vector<double> share_;  ///< of its fluxes that a vertex can take
  std::vector<SymTensor> limited_;
};

/// A lower triangular matrix, by rows.
struct Lower {
  double xx, yx, yy, zx, zy, zz;
};

Lower cholesky_factor(const SymTensor& a) {
  const double xx = std::sqrt(a.xx), yx = a.xy / xx, zx = a.xz / xx;
  const double yy = std::sqrt(a.yy - yx * yx), zy = (a.yz - zx * yx) / yy;
  return {xx, yx, yy, zx, zy, std::sqrt(a.zz - zx * zx - zy * zy)};
}

/// The lower triangular S for which S A S^T = B.
Lower congruence(const SymTensor& a, const SymTensor& b) {
  const Lower m = cholesky_factor(a), n = cholesky_factor(b);
  Lower s{n.xx / m.xx, 0, n.yy / m.yy, 0, 0, n.zz / m.zz};
  s.yx = (n.yx - s.yy * m.yx) / m.xx;
  s.zy = (n.zy - s.zz * m.zy) / m.yy;
  s.zx = (n.zx - s.zy * m.yx - s.zz * m.zx) / m.xx;
  return s;
}

SymTensor transformed(const Lower& s, const SymTensor& t) {
  const Vec x{s.xx, 0, 0}, y{s.yx, s.yy, 0}, z{s.zx, s.zy, s.zz};
  const Vec tx = apply(t, x), ty = apply(t, y), tz = apply(t, z);
  return {dot(x, tx), dot(x, ty), dot(y, ty), dot(x, tz), dot(y, tz), dot(z, tz)};
}

std::array<double, 6> entries(const SymTensor& t) { return {t.xx, t.xy, t.yy, t.xz, t.yz, t.zz}; }

/// Of all vertices.
SymTensor integral_of(const MetricDomain& domain, const MassMatrix& mass,
                      const std::vector<SymTensor>& tensors) {
  std::array<double, 6> sums;
  for (std::size_t c = 0; c < 6; ++c)
    sums[c] = domain.signed_sum([&](std::size_t v) { return mass.lumped()[v] * entries(tensors[v])[c]; });
  return tensor_at(sums, 0);
}

}  // namespace

std::array<double, 6> limit_tensors(const MetricDomain& domain, const MassMatrix& mass,
                                    const TensorColumns& columns, std::span<const double> loads,
                                    std::span<const double> lo, std::span<const double> hi,
                                    std::span<const double> wanted, ValueTable& table) {
  TensorLimiter limiter(domain, mass, columns, loads, lo, hi, table);
  const std::vector<SymTensor>& limited = limiter.run();
  const Lower s = congruence(integral_of(domain, mass, limited), tensor_at(wanted, columns.first));
  std::array<double, 6> change{};
  for (std::size_t v = 0; v < limited.size(); ++v) {
    if (!domain.owns(v) || !(mass.lumped()[v] > 0)) continue;
    const auto before = entries(limited[v]), after = entries(transformed(s, limited[v]));
    for (std::size_t c = 0; c < 6; ++c) {
      change[c] = std::max(change[c], std::abs(after[c] - before[c]));
      table.values[v * table.columns + columns.first + c] = after[c];
    }
  }
  for (double& c : change) c = domain.max(c);
  return change;
}

}  // namespace weft::meshing

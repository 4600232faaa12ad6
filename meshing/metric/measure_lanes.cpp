// Mean ratios and edge lengths with the arithmetic of eight at a time.
#include "meshing/metric/measure_lanes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "meshing/metric/measures.h"

namespace weft::meshing {
namespace {

typedef std::int64_t LongLanes __attribute__((vector_size(8 * kLanes)));
typedef std::uint64_t BitLanes __attribute__((vector_size(8 * kLanes)));

TensorLanes square(const TensorLanes& a) {
  return {a.xx * a.xx + a.xy * a.xy + a.xz * a.xz, a.xx * a.xy + a.xy * a.yy + a.xz * a.yz,
          a.xy * a.xy + a.yy * a.yy + a.yz * a.yz, a.xx * a.xz + a.xy * a.yz + a.xz * a.zz,
          a.xy * a.xz + a.yy * a.yz + a.yz * a.zz, a.xz * a.xz + a.yz * a.yz + a.zz * a.zz};
}

Lanes determinant(const TensorLanes& a) {
  return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) +
         a.xz * (a.xy * a.yz - a.yy * a.xz);
}

Lanes root_of(const Lanes& x) {
  Lanes root;
  for (int i = 0; i < kLanes; ++i) root[i] = std::sqrt(x[i]);
  return root;
}

TensorLanes scaled(const Lanes& s, const TensorLanes& a) {
  return {s * a.xx, s * a.xy, s * a.yy, s * a.xz, s * a.yz, s * a.zz};
}

/// p0 I + p1 A + p2 B
TensorLanes combined(const Lanes& p0, const Lanes& p1, const TensorLanes& a, const Lanes& p2,
                     const TensorLanes& b) {
  return {p0 + p1 * a.xx + p2 * b.xx, p1 * a.xy + p2 * b.xy, p0 + p1 * a.yy + p2 * b.yy,
          p1 * a.xz + p2 * b.xz,      p1 * a.yz + p2 * b.yz, p0 + p1 * a.zz + p2 * b.zz};
}

/// Corners and the sum of the logarithms there, of up to kLanes tets.
struct GatheredTets {
  std::array<std::array<std::array<double, kLanes>, 3>, 4> points;
  std::array<std::array<double, kLanes>, 6> logs;
};

GatheredTets gather(std::span<const std::array<std::uint32_t, 4>> tets, std::size_t first,
                    std::span<const Point> points, std::span<const LogMetric> log_metrics) {
  GatheredTets g;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const auto& tet = tets[std::min(first + i, tets.size() - 1)];
    for (std::size_t k = 0; k < 4; ++k) {
      const Point& p = points[tet[k]];
      g.points[k][0][i] = p.x, g.points[k][1][i] = p.y, g.points[k][2][i] = p.z;
    }
    const LogMetric sum =
        log_metrics[tet[0]] + log_metrics[tet[1]] + log_metrics[tet[2]] + log_metrics[tet[3]];
    const std::array<double, 6> entries = {sum.xx, sum.xy, sum.yy, sum.xz, sum.yz, sum.zz};
    for (std::size_t k = 0; k < 6; ++k) g.logs[k][i] = entries[k];
  }
  return g;
}

VecLanes difference(const GatheredTets& g, std::size_t a, std::size_t b) {
  const auto entry = [&](std::size_t k) {
    return load_lanes(g.points[a][k].data()) - load_lanes(g.points[b][k].data());
  };
  return {entry(0), entry(1), entry(2)};
}

/// Six-fold.
Lanes volumes(const VecLanes& e1, const VecLanes& e2, const VecLanes& e3) {
  return e1.x * (e2.y * e3.z - e2.z * e3.y) - e1.y * (e2.x * e3.z - e2.z * e3.x) +
         e1.z * (e2.x * e3.y - e2.y * e3.x);
}

Lanes squared_lengths(const TensorLanes& m, const VecLanes& v) { return dot(v, apply(m, v)); }

VecLanes operator-(const VecLanes& a, const VecLanes& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

const std::array<std::uint32_t, 4>& lane_of(std::span<const std::array<std::uint32_t, 4>> tets,
                                            std::size_t first, int lane) {
  return tets[std::min(first + static_cast<std::size_t>(lane), tets.size() - 1)];
}

/// The mean metrics of gathered tets, exp(third) times `unscaled`, and what a mean ratio takes of them: the
/// trace takes no part, since it scales volume and lengths alike.
struct MeanMetrics {
  explicit MeanMetrics(const GatheredTets& g) {
    TensorLanes x = scaled(Lanes{} + 0.25, load_lanes6(g.logs[0].data(), kLanes));
    third = (x.xx + x.yy + x.zz) / 3;
    x.xx -= third, x.yy -= third, x.zz -= third;
    norm2 = x.xx * x.xx + x.yy * x.yy + x.zz * x.zz + 2 * (x.xy * x.xy + x.xz * x.xz + x.yz * x.yz);
    unscaled = exp_of_traceless(x);
    edges = {difference(g, 1, 0), difference(g, 2, 0), difference(g, 3, 0)};
    volume = volumes(edges[0], edges[1], edges[2]) / 6;
  }

  /// exact(i) of lanes in which the anisotropy is too strong.
  template <class Exact>
  Lanes ratios(const Exact& exact) const {
    const Lanes sum = sum_squared_lengths(unscaled, edges[0], edges[1], edges[2]);
    const Lanes magnitude = kMeanRatioFactor * cube_root(volume * volume / (sum * sum * sum));
    Lanes result;
    for (int i = 0; i < kLanes; ++i) {
      const bool plain = norm2[i] <= kMaxExpNorm * kMaxExpNorm && sum[i] > 1e-80 && sum[i] < 1e80;
      // At most 1 but for rounding, which must not show in the histograms.
      result[i] = !plain           ? exact(i)
                  : volume[i] == 0 ? 0
                                   : std::copysign(std::min(magnitude[i], 1.0), volume[i]);
    }
    return result;
  }

  Lanes third, norm2, volume;
  TensorLanes unscaled;
  std::array<VecLanes, 3> edges;
};

}  // namespace

Lanes log_of_lanes(const Lanes& x) {
  // x = 2^e m with m in [sqrt(1/2), sqrt(2)); log m = 2 artanh(s), s = (m - 1) / (m + 1), of which the series
  // has converged after the power 21.
  constexpr std::uint64_t kHalfRoot = 0x3FE6A09E667F3BCD;  // sqrt(1/2)
  BitLanes bits;
  std::memcpy(&bits, &x, sizeof bits);
  const LongLanes exponent = reinterpret_cast<LongLanes>(bits - kHalfRoot) >> 52;
  bits -= reinterpret_cast<BitLanes>(exponent) << 52;
  Lanes m;
  std::memcpy(&m, &bits, sizeof m);
  const Lanes s = (m - 1) / (m + 1), s2 = s * s;
  Lanes series = Lanes{} + 1.0 / 21;
  for (int n = 19; n > 0; n -= 2) series = series * s2 + 1.0 / n;
  return __builtin_convertvector(exponent, Lanes) * std::numbers::ln2 + 2 * s * series;
}

Lanes log10_for_bins(const Lanes& x) {
  constexpr double kLeast = 1e-300;
  const Lanes positive = x > kLeast ? x : Lanes{} + kLeast;
  return log_of_lanes(positive) * std::numbers::log10e;
}

TensorLanes exp_of_traceless(const TensorLanes& x) {
  constexpr int kSquarings = 6, kDegree = 10;  // a norm of 10 becomes 0.16: the next term is below 1e-16
  TensorLanes a = scaled(Lanes{} + 1.0 / (1 << kSquarings), x);
  const TensorLanes a2 = square(a);
  // Cayley-Hamilton without trace: A^3 = s A + d I. A power is u I + v A + w A^2.
  const Lanes s = 0.5 * (a2.xx + a2.yy + a2.zz), d = determinant(a);
  Lanes p0 = Lanes{} + 1, p1 = Lanes{} + 1, p2 = Lanes{} + 0.5;
  Lanes u{}, v{}, w = Lanes{} + 0.5;  // A^2 / 2!
  for (int n = 3; n <= kDegree; ++n) {
    const Lanes next_u = w * d, next_v = u + w * s;
    w = v / n, u = next_u / n, v = next_v / n;
    p0 += u, p1 += v, p2 += w;
  }
  a = combined(p0, p1, a, p2, a2);
  for (int i = 0; i < kSquarings; ++i) a = square(a);
  return a;
}

Lanes mean_ratios(std::span<const std::array<std::uint32_t, 4>> tets, std::size_t first,
                  std::span<const Point> points, std::span<const LogMetric> log_metrics) {
  const MeanMetrics mean(gather(tets, first, points, log_metrics));
  return mean.ratios([&](int i) {
    const auto& [a, b, c, d] = lane_of(tets, first, i);
    return mean_ratio({points[a], points[b], points[c], points[d]},
                      {log_metrics[a], log_metrics[b], log_metrics[c], log_metrics[d]});
  });
}

TetLanes measure_tets(std::span<const std::array<std::uint32_t, 4>> tets, std::size_t first,
                      std::span<const Point> points, std::span<const LogMetric> log_metrics) {
  const MeanMetrics mean(gather(tets, first, points, log_metrics));
  const auto [e1, e2, e3] = mean.edges;
  const std::array<VecLanes, 6> edges = {e1, e2, e3, e2 - e1, e3 - e1, e3 - e2};
  TetLanes result{{}, mean.volume, {}};
  for (std::size_t e = 0; e < edges.size(); ++e)
    result.squared_lengths[e] = squared_lengths(mean.unscaled, edges[e]);
  for (int i = 0; i < kLanes; ++i) {
    const double scale = std::exp(mean.third[i]);
    for (Lanes& length : result.squared_lengths) length[i] *= scale;
    result.volumes[i] *= scale * std::sqrt(scale);
  }
  result.ratios = mean.ratios([&](int i) {
    const auto& [a, b, c, d] = lane_of(tets, first, i);
    const Metric metric =
        exp_fast(0.25 * (log_metrics[a] + log_metrics[b] + log_metrics[c] + log_metrics[d]));
    for (std::size_t e = 0; e < edges.size(); ++e)
      result.squared_lengths[e][i] = squared_length(metric, {edges[e].x[i], edges[e].y[i], edges[e].z[i]});
    return mean_ratio({points[a], points[b], points[c], points[d]},
                      {log_metrics[a], log_metrics[b], log_metrics[c], log_metrics[d]});
  });
  return result;
}

void EdgeBatch::add(const Vec& edge, const Metric& a, const Metric& b) {
  const auto put = [i = static_cast<std::size_t>(size_)](auto& rows, std::size_t k, double value) {
    rows[k][i] = value;
  };
  put(edges_, 0, edge.x), put(edges_, 1, edge.y), put(edges_, 2, edge.z);
  const auto put_metric = [&](auto& rows, const Metric& m) {
    put(rows, 0, m.xx), put(rows, 1, m.xy), put(rows, 2, m.yy);
    put(rows, 3, m.xz), put(rows, 4, m.yz), put(rows, 5, m.zz);
  };
  put_metric(a_, a), put_metric(b_, b);
  ++size_;
}

Lanes EdgeBatch::take_lengths() {
  size_ = 0;
  const VecLanes e = load_lanes3(edges_[0].data(), kLanes);
  const Lanes la = root_of(squared_lengths(load_lanes6(a_[0].data(), kLanes), e));
  const Lanes lb = root_of(squared_lengths(load_lanes6(b_[0].data(), kLanes), e));
  // log_mean_length() of metric.h.
  const Lanes d = la - lb, mean = 0.5 * (la + lb);
  const auto differ = absolute(d) > 0.001;
  const Lanes ratio = differ ? la / lb : Lanes{} + 2;
  return differ ? d / log_of_lanes(ratio) : mean;
}

}  // namespace weft::meshing

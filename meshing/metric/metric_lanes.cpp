// Jacobi's rotations of eight tensors at a time.
#include "meshing/metric/metric_lanes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "meshing/base/assert.h"
#include "meshing/metric/measure_lanes.h"

namespace weft::meshing {
namespace {

Lanes square_root(const Lanes& x) {
  Lanes root;
  for (int i = 0; i < kLanes; ++i) root[i] = std::sqrt(x[i]);
  return root;
}

/// The rotation that makes the entry pq zero, by its angle's tangent, sine and cosine.
struct Rotation {
  Lanes t, s, c;
  Rotation(const Lanes& pp, const Lanes& qq, const Lanes& pq) {
    const Lanes theta = (qq - pp) / (2 * pq);
    const Lanes smaller = 1 / (absolute(theta) + square_root(theta * theta + 1));
    t = pq == 0 ? Lanes{} : theta < 0 ? -smaller : smaller;
    c = 1 / square_root(t * t + 1);
    s = t * c;
  }
};

void turn(const Rotation& r, Lanes& p, Lanes& q) {
  const Lanes old = p;
  p = r.c * old - r.s * q;
  q = r.s * old + r.c * q;
}

/// Rotates rows and columns p and q of a tensor whose third is r.
void rotate(Lanes& pp, Lanes& qq, Lanes& pq, Lanes& pr, Lanes& qr, VecLanes& vp, VecLanes& vq) {
  const Rotation r(pp, qq, pq);
  const Lanes more = r.t * pq;
  pp -= more, qq += more, pq = Lanes{};
  turn(r, pr, qr);
  turn(r, vp.x, vq.x), turn(r, vp.y, vq.y), turn(r, vp.z, vq.z);
}

/// Up to eight tensors; the last one fills what is left.
TensorLanes load(std::span<const SymTensor> tensors) {
  TensorLanes a;
  for (int i = 0; i < kLanes; ++i) {
    const SymTensor& t = tensors[std::min(static_cast<std::size_t>(i), tensors.size() - 1)];
    a.xx[i] = t.xx, a.xy[i] = t.xy, a.yy[i] = t.yy, a.xz[i] = t.xz, a.yz[i] = t.yz, a.zz[i] = t.zz;
  }
  return a;
}

/// The tensors with these eigenvectors, and `f` of the eigenvalues.
TensorLanes tensor_of(const std::array<Lanes, 3>& f, const std::array<VecLanes, 3>& vectors) {
  TensorLanes a{};
  for (std::size_t k = 0; k < 3; ++k) {
    const VecLanes &v = vectors[k], fv = f[k] * v;
    a.xx += fv.x * v.x, a.xy += fv.x * v.y, a.yy += fv.y * v.y;
    a.xz += fv.x * v.z, a.yz += fv.y * v.z, a.zz += fv.z * v.z;
  }
  return a;
}

SymTensor entry(const TensorLanes& a, int i) {
  return {a.xx[i], a.xy[i], a.yy[i], a.xz[i], a.yz[i], a.zz[i]};
}

Lanes off_diagonal(const TensorLanes& a) { return absolute(a.xy) + absolute(a.xz) + absolute(a.yz); }
Lanes diagonal(const TensorLanes& a) { return absolute(a.xx) + absolute(a.yy) + absolute(a.zz); }

/// Entries off the diagonal that are too small to show in doubles become zero: no rotation turns such a
/// tensor any more, whatever its neighbours in the lanes need. False where all are so.
bool has_rotations_left(TensorLanes& a) {
  constexpr double kNothing = 1e-20;
  const auto none = off_diagonal(a) <= kNothing * diagonal(a);
  a.xy = none ? Lanes{} : a.xy, a.xz = none ? Lanes{} : a.xz, a.yz = none ? Lanes{} : a.yz;
  bool any = false;
  for (int i = 0; i < kLanes; ++i) any |= none[i] == 0;
  return any;
}

}  // namespace

EigenLanes eigen_of_lanes(const TensorLanes& given) {
  constexpr int kSweeps = 6;  // convergence is quadratic: four or five are enough for all but a few
  constexpr double kRounding = 1e-15;
  TensorLanes a = given;
  const Lanes one = Lanes{} + 1;
  std::array<VecLanes, 3> v = {{{one, {}, {}}, {{}, one, {}}, {{}, {}, one}}};
  for (int i = 0; i < kSweeps && has_rotations_left(a); ++i) {
    rotate(a.xx, a.yy, a.xy, a.xz, a.yz, v[0], v[1]);
    rotate(a.xx, a.zz, a.xz, a.xy, a.yz, v[0], v[2]);
    rotate(a.yy, a.zz, a.yz, a.xy, a.xz, v[1], v[2]);
  }
  const auto done = off_diagonal(a) <= kRounding * diagonal(a);
  const Lanes none = Lanes{} + std::numeric_limits<double>::quiet_NaN();
  return {{done ? a.xx : none, done ? a.yy : none, done ? a.zz : none}, v};
}

unsigned logs_of(std::span<const SymTensor> metrics, std::span<LogMetric> logs) {
  WEFT_ASSERT_LIGHT(metrics.size() <= kLanes && logs.size() == metrics.size(), "eight at most");
  constexpr double kClearly = 1e-12, kTiny = 1e-280, kHuge = 1e280;
  const EigenLanes e = eigen_of_lanes(load(metrics));
  std::array<Lanes, 3> f;
  for (std::size_t k = 0; k < 3; ++k) f[k] = log_of_lanes(e.values[k]);
  const TensorLanes l = tensor_of(f, e.vectors);
  unsigned left = 0;
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    const int lane = static_cast<int>(i);
    const auto [least, most] = std::minmax({e.values[0][lane], e.values[1][lane], e.values[2][lane]});
    if (least > kClearly * most && least > kTiny && most < kHuge)
      logs[i] = entry(l, lane);
    else
      left |= 1u << i;
  }
  return left;
}

void exps_of(std::span<const LogMetric> logs, std::span<Metric> metrics) {
  WEFT_ASSERT_LIGHT(logs.size() <= kLanes && metrics.size() == logs.size(), "eight at most");
  const EigenLanes e = eigen_of_lanes(load(logs));
  std::array<Lanes, 3> f;
  for (std::size_t k = 0; k < 3; ++k)
    for (int i = 0; i < kLanes; ++i) f[k][i] = std::exp(e.values[k][i]);
  const TensorLanes m = tensor_of(f, e.vectors);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    metrics[i] = entry(m, static_cast<int>(i));
    if (!std::isfinite(trace(metrics[i]))) metrics[i] = exp_exact(logs[i]);
  }
}

}  // namespace weft::meshing

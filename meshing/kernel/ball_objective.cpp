// Derivatives and qualities of a ball, eight tets at a time.
#include "meshing/kernel/ball_objective.h"

#include <algorithm>

#include "meshing/metric/measure_lanes.h"

namespace weft::meshing {
namespace {

double sum(const Lanes& v) {
  double s = 0;
  for (int i = 0; i < kLanes; ++i) s += v[i];
  return s;
}

/// Mean ratios from six-fold volumes, determinants of the metrics and sums of squared lengths. The root is
/// taken of a number that does not depend on the scale of the metric, as single precision could not hold the
/// others.
Lanes mean_ratio(const Lanes& volume, const Lanes& det, const Lanes& s) {
  return kMeanRatioFactor * cube_root(volume * volume * det / (36 * s * s * s));
}

struct HessianLanes {
  Lanes xx{}, xy{}, yy{}, xz{}, yz{}, zz{};
};

/// h += s u u^T
void add_square(HessianLanes& h, const Lanes& s, const VecLanes& u) {
  const VecLanes su = s * u;
  h.xx += su.x * u.x;
  h.xy += su.x * u.y;
  h.yy += su.y * u.y;
  h.xz += su.x * u.z;
  h.yz += su.y * u.z;
  h.zz += su.z * u.z;
}

/// The log-Euclidean means that four logarithms each add up to, of determinant 1: qualities do not depend on
/// the scale of the mean.
TensorLanes mean_of_logs(TensorLanes x) {
  for (Lanes* entry : {&x.xx, &x.xy, &x.yy, &x.xz, &x.yz, &x.zz}) *entry *= 0.25;
  const Lanes third = (x.xx + x.yy + x.zz) / 3;
  x.xx -= third, x.yy -= third, x.zz -= third;
  const Lanes norm2 = x.xx * x.xx + x.yy * x.yy + x.zz * x.zz + 2 * (x.xy * x.xy + x.xz * x.xz + x.yz * x.yz);
  TensorLanes e = exp_of_traceless(x);
  for (int i = 0; i < kLanes; ++i) {
    if (norm2[i] <= kMaxExpNorm * kMaxExpNorm) continue;
    const SymTensor one = exp_fast({x.xx[i], x.xy[i], x.yy[i], x.xz[i], x.yz[i], x.zz[i]});
    e.xx[i] = one.xx, e.xy[i] = one.xy, e.yy[i] = one.yy;
    e.xz[i] = one.xz, e.yz[i] = one.yz, e.zz[i] = one.zz;
  }
  return e;
}

}  // namespace

void BallFaces::set(int k, const TetMesh& mesh, VertexId a, VertexId b, VertexId c) {
  const Point& o = mesh.point(a);
  const Vec e1 = mesh.point(b) - o, e2 = mesh.point(c) - o;
  for (int i = 0; i < 3; ++i) {
    row(kOrigin + i)[k] = o[i];
    row(kEdge1 + i)[k] = e1[i];
    row(kEdge2 + i)[k] = e2[i];
  }
  const SymTensor t =
      judge_tensor(mean_, mesh, a) + judge_tensor(mean_, mesh, b) + judge_tensor(mean_, mesh, c);
  const double entries[6] = {t.xx, t.xy, t.yy, t.xz, t.yz, t.zz};
  for (int i = 0; i < 6; ++i) row(kTensor + i)[k] = entries[i];
}

void BallFaces::gather(MetricMean mean, const TetMesh& mesh, const Ball& ball) {
  mesh_ = &mesh;
  ball_ = &ball;
  mean_ = mean;
  size_ = static_cast<int>(ball.tets.size());
  stride_ = (size_ + kLanes - 1) / kLanes * kLanes;
  const auto needed = static_cast<std::size_t>(kRows) * static_cast<std::size_t>(stride_);
  if (data_.size() < needed) data_.resize(needed);
  for (int k = 0; k < size_; ++k) {
    const auto [t, local] = ball.tets[k];
    const auto& f = kTetFaces[local];
    set(k, mesh, mesh.vertex(t, f[0]), mesh.vertex(t, f[1]), mesh.vertex(t, f[2]));
  }
  for (int r = 0; r < kGathered; ++r) {
    if (r >= kNormal && r < kTensor) continue;
    for (int k = size_; k < stride_; ++k) row(r)[k] = row(r)[size_ - 1];
  }
  for (int k = 0; k < stride_; ++k) row(kWeight)[k] = k < size_ ? 1 : 0;
  for (int k = 0; k < stride_; k += kLanes) {
    const VecLanes a = load_lanes3(row(kEdge1) + k, stride_), b = load_lanes3(row(kEdge2) + k, stride_);
    const auto store = [&](int i, const Lanes& one, const Lanes& other) {
      store_lanes(row(kNormal + i) + k, one - other);
      store_lanes(row(kAbsNormal + i) + k, absolute(one) + absolute(other));
    };
    store(0, a.y * b.z, a.z * b.y);
    store(1, a.z * b.x, a.x * b.z);
    store(2, a.x * b.y, a.y * b.x);
  }
}

void BallFaces::average(const SymTensor& centre) {
  const double c[6] = {centre.xx, centre.xy, centre.yy, centre.xz, centre.yz, centre.zz};
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < stride_; ++k) row(kMean + i)[k] = row(kTensor + i)[k] + c[i];
  if (mean_ != MetricMean::log_euclidean) return;
  for (int k = 0; k < stride_; k += kLanes) {
    const TensorLanes mean = mean_of_logs(load_lanes6(row(kMean) + k, stride_));
    const Lanes* entries[6] = {&mean.xx, &mean.xy, &mean.yy, &mean.xz, &mean.yz, &mean.zz};
    for (int i = 0; i < 6; ++i) store_lanes(row(kMean + i) + k, *entries[i]);
    store_lanes(row(kDeterminant) + k, Lanes{} + 1);
  }
}

Lanes BallFaces::determinants(int k, const TensorLanes& mean) const {
  return mean_ == MetricMean::log_euclidean ? load_lanes(row(kDeterminant) + k)
                                            : determinant_of_definite(mean);
}

bool BallFaces::is_positive(int k, const Point& x) const {
  const auto [t, local] = ball_->tets[k];
  const auto& f = kTetFaces[local];
  return orientation(mesh_->point(mesh_->vertex(t, f[0])), mesh_->point(mesh_->vertex(t, f[1])),
                     mesh_->point(mesh_->vertex(t, f[2])), x) > 0;
}

BallDerivatives BallFaces::derivatives(const Point& x, const SymTensor& centre) {
  average(centre);
  Lanes value{};
  VecLanes gradient{};
  HessianLanes h;
  for (int k = 0; k < stride_; k += kLanes) {
    const TensorLanes m = load_lanes6(row(kMean) + k, stride_);
    const VecLanes e1 = load_lanes3(row(kEdge1) + k, stride_), e2 = load_lanes3(row(kEdge2) + k, stride_);
    const VecLanes n = load_lanes3(row(kNormal) + k, stride_), o = load_lanes3(row(kOrigin) + k, stride_);
    const VecLanes e3 = {x.x - o.x, x.y - o.y, x.z - o.z};
    const Lanes raw = dot(n, e3);
    const Lanes volume = raw > 0 ? raw : Lanes{} + 1;
    const Lanes s = sum_squared_lengths(m, e1, e2, e3);
    const Lanes det = determinants(k, m);
    Lanes f = 1 / mean_ratio(volume, det, s);
    f = ((raw > 0) & (det > 0)) ? f * load_lanes(row(kWeight) + k) : Lanes{};
    // S' = 2 M (3 x - sum of the face's points), S'' = 6 M; g is the gradient of the logarithm of 1/Q.
    const VecLanes direction = {3 * e3.x - e1.x - e2.x, 3 * e3.y - e1.y - e2.y, 3 * e3.z - e1.z - e2.z};
    const VecLanes ds = (2 / s) * apply(m, direction), dv = (1 / volume) * n;
    const VecLanes g = {ds.x - (2.0 / 3) * dv.x, ds.y - (2.0 / 3) * dv.y, ds.z - (2.0 / 3) * dv.z};
    const VecLanes fg = f * g;
    store_lanes(row(kValue) + k, f);
    store_lanes(row(kGradient) + k, fg.x);
    store_lanes(row(kGradient + 1) + k, fg.y);
    store_lanes(row(kGradient + 2) + k, fg.z);
    value += f;
    gradient = {gradient.x + fg.x, gradient.y + fg.y, gradient.z + fg.z};
    add_square(h, f, g);
    add_square(h, -f, ds);
    add_square(h, (2.0 / 3) * f, dv);
    const Lanes c = 6 * f / s;
    h.xx += c * m.xx;
    h.xy += c * m.xy;
    h.yy += c * m.yy;
    h.xz += c * m.xz;
    h.yz += c * m.yz;
    h.zz += c * m.zz;
  }
  return {sum(value),
          {sum(gradient.x), sum(gradient.y), sum(gradient.z)},
          {sum(h.xx), sum(h.xy), sum(h.yy), sum(h.xz), sum(h.yz), sum(h.zz)}};
}

double BallFaces::qualities(const Point& x, const SymTensor& centre, std::vector<float>& qualities) {
  average(centre);
  qualities.resize(stride_);
  for (int k = 0; k < stride_; k += kLanes) {
    const TensorLanes m = load_lanes6(row(kMean) + k, stride_);
    const VecLanes e1 = load_lanes3(row(kEdge1) + k, stride_), e2 = load_lanes3(row(kEdge2) + k, stride_);
    const VecLanes n = load_lanes3(row(kNormal) + k, stride_), o = load_lanes3(row(kOrigin) + k, stride_);
    const VecLanes e3 = {x.x - o.x, x.y - o.y, x.z - o.z};
    const Lanes volume = dot(n, e3);
    // The filter of predicates.h with the centre's row last.
    const VecLanes products = load_lanes3(row(kAbsNormal) + k, stride_);
    const Lanes doubt = volume - 1e-15 * (products.x * absolute(e3.x) + products.y * absolute(e3.y) +
                                          products.z * absolute(e3.z));
    const Lanes positive = volume > 0 ? volume : Lanes{};
    const Lanes det = determinants(k, m);
    const Lanes ratio = mean_ratio(positive, det, sum_squared_lengths(m, e1, e2, e3));
    const Lanes q = ((det > 0) & (ratio < kNoQuality)) ? ratio : Lanes{} - 1;
    for (int i = 0; i < kLanes; ++i) {
      if (!(doubt[i] > 0) && !is_positive(std::min(k + i, size_ - 1), x)) return -1;
      qualities[k + i] = static_cast<float>(q[i]);
    }
  }
  qualities.resize(size_);
  return *std::min_element(qualities.begin(), qualities.end());
}

}  // namespace weft::meshing

// All in lanes that is plain; what is in doubt is left to the judges of single tets and edges.
#include "meshing/kernel/tet_batch.h"

#include "meshing/kernel/quality.h"

namespace weft::meshing {
namespace {

VecLanes cross(const VecLanes& a, const VecLanes& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

TensorLanes operator+(const TensorLanes& a, const TensorLanes& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy, a.xz + b.xz, a.yz + b.yz, a.zz + b.zz};
}

/// Where the determinant of three edges is proven to be positive, as orientation() does it.
auto proven_positive(const VecLanes& u, const VecLanes& v, const VecLanes& w) {
  const Lanes yz = v.y * w.z, zy = v.z * w.y, zx = v.z * w.x, xz = v.x * w.z, xy = v.x * w.y, yx = v.y * w.x;
  const Lanes det = u.x * (yz - zy) + u.y * (zx - xz) + u.z * (xy - yx);
  const Lanes permanent = absolute(u.x) * (absolute(yz) + absolute(zy)) +
                          absolute(u.y) * (absolute(zx) + absolute(xz)) +
                          absolute(u.z) * (absolute(xy) + absolute(yx));
  return det > 1e-15 * permanent;
}

}  // namespace

void TetBatch::add(TetId t) {
  const auto at = static_cast<std::size_t>(size_++);
  SeenTet& seen = seen_[at];
  seen.tet = t;
  seen.vertices = mesh_.vertices(t);
  for (std::size_t i = 0; i < 4; ++i) {
    const Point& p = mesh_.point(seen.vertices[i]);
    points_[i][0][at] = p.x, points_[i][1][at] = p.y, points_[i][2][at] = p.z;
    const Metric& m = mesh_.metric(seen.vertices[i]);
    metrics_[i][0][at] = m.xx, metrics_[i][1][at] = m.xy, metrics_[i][2][at] = m.yy;
    metrics_[i][3][at] = m.xz, metrics_[i][4][at] = m.yz, metrics_[i][5][at] = m.zz;
  }
}

VecLanes TetBatch::edge(std::size_t a, std::size_t b) const {
  const auto entry = [&](std::size_t k) {
    return load_lanes(points_[b][k].data()) - load_lanes(points_[a][k].data());
  };
  return {entry(0), entry(1), entry(2)};
}

void TetBatch::look() {
  look_at_edges();
  look_at_qualities();
}

void TetBatch::look_at_edges() {
  const double below = short_edge_ * short_edge_, above = long_edge_ * long_edge_;
  std::array<TensorLanes, 4> metrics;
  for (std::size_t i = 0; i < 4; ++i) metrics[i] = load_lanes6(metrics_[i][0].data(), kLanes);
  for (SeenTet& seen : seen_) seen.short_edges = 0, seen.has_long_edge = false;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto a = static_cast<std::size_t>(kTetEdges[e][0]), b = static_cast<std::size_t>(kTetEdges[e][1]);
    const VecLanes v = edge(a, b);
    const Lanes by_a = dot(v, apply(metrics[a], v)), by_b = dot(v, apply(metrics[b], v));
    // As MetricLength compares: the metrics of both ends agree but for a few edges.
    const auto is_short = (by_a < below) & (by_b < below), is_long = (by_a > above) & (by_b > above);
    const auto in_doubt = ((by_a < below) ^ (by_b < below)) | ((by_a > above) ^ (by_b > above));
    const auto any = is_short | is_long | in_doubt;
    for (int i = 0; i < size_; ++i) {
      if (!any[i]) continue;
      SeenTet& seen = seen_[static_cast<std::size_t>(i)];
      const MetricLength length{by_a[i], by_b[i]};
      if (length.below(short_edge_)) seen.short_edges |= static_cast<std::uint8_t>(1u << e);
      seen.has_long_edge |= length.above(long_edge_);
    }
  }
}

void TetBatch::look_at_qualities() {
  // Cube roots are taken in single precision at first.
  constexpr double kLeastCube = 1e-30, kLargestCube = 1e30;
  const VecLanes e1 = edge(0, 1), e2 = edge(0, 2), e3 = edge(0, 3);
  TensorLanes m = load_lanes6(metrics_[0][0].data(), kLanes);
  for (std::size_t i = 1; i < 4; ++i) m = m + load_lanes6(metrics_[i][0].data(), kLanes);
  const Lanes volume = dot(cross(e1, e2), e3), lengths = sum_squared_lengths(m, e1, e2, e3);
  const Lanes v = volume * (1.0 / 6);
  const Lanes det = determinant_of_definite(m);
  const Lanes cube = v * v * det;
  const Lanes quality = kMeanRatioFactor * cube_root(cube) / lengths;
  const auto plain = proven_positive(e1, e2, e3) & (volume > 0) & (det > 0) & (cube > kLeastCube) &
                     (cube < kLargestCube) & (quality >= 0) & (quality < kNoQuality);
  for (int i = 0; i < size_; ++i) {
    SeenTet& seen = seen_[static_cast<std::size_t>(i)];
    seen.quality = plain[i] ? quality[i] : judge_quality(MetricMean::arithmetic, mesh_, seen.vertices);
  }
}

}  // namespace weft::meshing

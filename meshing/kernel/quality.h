// The quality that operators judge by: mean ratio in a mean of the vertices' metrics, cheap or exact
// (MetricMean). Reports use measures.h, which takes the log-Euclidean mean; the two agree where the mesh
// resolves the metric.
#pragma once

#include <bit>
#include <cmath>

#include "meshing/kernel/tet_mesh.h"
#include "meshing/mesh/predicates.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Mean of metrics. The arithmetic one is cheap and right where neighbours' metrics are alike; where the
/// metric changes manifold within one tet the largest of the four would decide alone, and the log-Euclidean
/// mean is needed.
/// `euclidean` judges shapes as they are: for the time before a coarse mesh has anything to do with the
/// metric.
enum class MetricMean : std::uint8_t { arithmetic, log_euclidean, euclidean };

/// Sum over the six edges of v.M.v for a tet whose edges from vertex 0 are e1, e2, e3.
inline double sum_squared_lengths(const SymTensor& m, const Vec& e1, const Vec& e2, const Vec& e3) {
  const Vec m1 = apply(m, e1), m2 = apply(m, e2), m3 = apply(m, e3);
  return 3 * (dot(e1, m1) + dot(e2, m2) + dot(e3, m3)) - 2 * (dot(e2, m1) + dot(e3, m1) + dot(e3, m2));
}

/// Cube root of a positive normal number to about 1e-13: a bit-level guess and two Halley steps, a third of
/// the cost of std::cbrt.
inline double fast_cbrt(double x) {
  double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + 0x2A9F7893782DA1CEull);
  for (int i = 0; i < 2; ++i) {
    const double y3 = y * y * y;
    y *= (y3 + 2 * x) / (2 * y3 + x);
  }
  return y;
}

/// Mean ratio of a tet of positive six_volume in the mean of its four vertices' metrics, or any multiple of
/// it: the measure does not depend on the metric's scale. `det` is the metric's determinant.
inline double mean_ratio(double six_volume, const SymTensor& m, double det, const Vec& e1, const Vec& e2,
                         const Vec& e3) {
  const double v = six_volume * (1.0 / 6);
  return kMeanRatioFactor * fast_cbrt(v * v * det) / sum_squared_lengths(m, e1, e2, e3);
}

/// The metric, up to scale, that the four tensors of a tet's vertices (metrics or logarithms, by the kind of
/// mean) add up to.
inline SymTensor mean_of_sum(MetricMean mean, const SymTensor& sum) {
  return mean == MetricMean::log_euclidean ? exp_fast(0.25 * sum) : sum;
}
/// The determinant of that mean: of an exponential it is known without rounding, from the trace.
inline double determinant_of_mean(MetricMean kind, const SymTensor& sum, const SymTensor& mean) {
  return kind == MetricMean::log_euclidean ? std::exp(0.25 * trace(sum)) : determinant_of_definite(mean);
}

/// No mean ratio is as large (the largest is 1, and rounding): what is not below has overflown.
inline constexpr double kNoQuality = 2;

/// A vertex as the judges see it: its place and the tensor that the kind of mean adds up.
struct Corner {
  Point x;
  SymTensor tensor;
};
inline const SymTensor& judge_tensor(MetricMean mean, const Metric& metric, const LogMetric& log_metric) {
  static constexpr SymTensor kIdentity = {1, 0, 1, 0, 0, 1};
  return mean == MetricMean::arithmetic ? metric : mean == MetricMean::log_euclidean ? log_metric : kIdentity;
}
inline const SymTensor& judge_tensor(MetricMean mean, const TetMesh& mesh, VertexId v) {
  return judge_tensor(mean, mesh.metric(v), mesh.log_metric(v));
}
inline Corner corner(MetricMean mean, const TetMesh& mesh, VertexId v) {
  return {mesh.point(v), judge_tensor(mean, mesh, v)};
}

/// Mean ratio of tet (a,b,c,d), or -1 when it is not exactly POSITIVE or when its metrics have no mean that
/// is positive definite in doubles: then nothing can be said of it.
inline double judge_quality(MetricMean mean, const Corner& a, const Corner& b, const Corner& c,
                            const Corner& d) {
  const Vec e1 = b.x - a.x, e2 = c.x - a.x, e3 = d.x - a.x;
  if (orientation(a.x, b.x, c.x, d.x) <= 0) return -1;
  const double volume = dot(cross(e1, e2), e3);
  if (!(volume > 0)) return 0;
  const SymTensor sum = a.tensor + b.tensor + c.tensor + d.tensor, m = mean_of_sum(mean, sum);
  const double det = determinant_of_mean(mean, sum, m);
  if (!(det > 0)) return -1;
  const double q = mean_ratio(volume, m, det, e1, e2, e3);
  return q >= 0 && q < kNoQuality ? q : -1;
}

/// The same for a judge who only wants to know a quality that is larger than `bound` >= 0: for one that is
/// not, 0 or -1. The comparison is of cubes, which take no root.
inline double judge_quality_above(double bound, MetricMean mean, const Corner& a, const Corner& b,
                                  const Corner& c, const Corner& d) {
  const Vec e1 = b.x - a.x, e2 = c.x - a.x, e3 = d.x - a.x;
  if (orientation(a.x, b.x, c.x, d.x) <= 0) return -1;
  const double volume = dot(cross(e1, e2), e3);
  if (!(volume > 0)) return 0;
  const SymTensor sum = a.tensor + b.tensor + c.tensor + d.tensor, m = mean_of_sum(mean, sum);
  const double det = determinant_of_mean(mean, sum, m);
  if (!(det > 0)) return -1;
  const double lengths = sum_squared_lengths(m, e1, e2, e3), cube = volume * volume * det * (1.0 / 36),
               least = bound * lengths * (1 / kMeanRatioFactor);
  if (cube <= least * least * least) return 0;
  const double q = kMeanRatioFactor * fast_cbrt(cube) / lengths;
  return q >= 0 && q < kNoQuality ? q : -1;
}

inline double judge_quality(MetricMean mean, const TetMesh& mesh, const TetVertices& v) {
  return judge_quality(mean, corner(mean, mesh, v[0]), corner(mean, mesh, v[1]), corner(mean, mesh, v[2]),
                       corner(mean, mesh, v[3]));
}

/// The length of an edge, compared with bounds by its squares in the metrics of its ends where these agree:
/// roots are taken of the few lengths in doubt.
struct MetricLength {
  double a, b;  ///< squared, in the metric of either end

  bool above(double bound) const { return compare<true>(bound); }
  bool below(double bound) const { return compare<false>(bound); }
  double value() const { return edge_length_of_squares(a, b); }

 private:
  template <bool kAbove>
  bool compare(double bound) const {
    const double square = bound * bound;
    const bool first = kAbove ? a > square : a < square, second = kAbove ? b > square : b < square;
    return first == second ? first : kAbove ? value() > bound : value() < bound;
  }
};
inline MetricLength edge_between(const TetMesh& mesh, VertexId a, VertexId b) {
  const Vec e = mesh.point(b) - mesh.point(a);
  return {squared_length(mesh.metric(a), e), squared_length(mesh.metric(b), e)};
}

inline double length_between(const TetMesh& mesh, VertexId a, VertexId b) {
  return edge_length_fast(mesh.point(b) - mesh.point(a), mesh.metric(a), mesh.metric(b));
}

}  // namespace weft::meshing

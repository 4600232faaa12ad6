// The metric: a symmetric positive definite 3x3 tensor, its logarithm, and lengths measured in it.
// Formulas: DESIGN of measures; log-Euclidean calculus after Arsigny et al. (2006).
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "meshing/base/point.h"
#include "weft/data.h"

namespace weft::meshing {

/// A SymTensor that is positive definite; lengths in it are counted in units of the wanted size.
using Metric = SymTensor;
/// The matrix logarithm of a Metric: the space in which metrics are averaged and interpolated.
using LogMetric = SymTensor;

inline SymTensor operator+(const SymTensor& a, const SymTensor& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy, a.xz + b.xz, a.yz + b.yz, a.zz + b.zz};
}
inline SymTensor operator-(const SymTensor& a, const SymTensor& b) {
  return {a.xx - b.xx, a.xy - b.xy, a.yy - b.yy, a.xz - b.xz, a.yz - b.yz, a.zz - b.zz};
}
inline SymTensor operator*(double s, const SymTensor& a) {
  return {s * a.xx, s * a.xy, s * a.yy, s * a.xz, s * a.yz, s * a.zz};
}
inline SymTensor identity_tensor(double d = 1) { return {d, 0, d, 0, 0, d}; }

inline double trace(const SymTensor& a) { return a.xx + a.yy + a.zz; }
/// By expansion: for tensors that may be indefinite.
inline double determinant(const SymTensor& a) {
  return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) +
         a.xz * (a.xy * a.yz - a.yy * a.xz);
}
/// Determinant of a positive definite tensor: the first pivot times the minor of what is left, two steps of
/// elimination with one division. The relative error is about eps times the condition number, that of an
/// expansion eps times its square: all digits at sizes of 1:1e4. Not positive, or not finite: the tensor is
/// not definite as far as doubles show. `T` is SymTensor or TensorLanes.
template <class T>
auto determinant_of_definite(const T& a) {
  const auto inverse = 1 / a.xx;
  const auto xy = a.xy * inverse, xz = a.xz * inverse;
  const auto yy = a.yy - xy * a.xy, yz = a.yz - xy * a.xz, zz = a.zz - xz * a.xz;
  return a.xx * (yy * zz - yz * yz);
}
inline Vec apply(const SymTensor& m, const Vec& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
/// v.M.v, the squared length of v in M.
inline double squared_length(const SymTensor& m, const Vec& v) { return dot(v, apply(m, v)); }

/// Eigen-decomposition: values ascending, vectors[i] the unit eigenvector of values[i].
struct Eigen3 {
  std::array<double, 3> values;
  std::array<Vec, 3> vectors;
};
Eigen3 eigen_decomposition(const SymTensor& a);
SymTensor from_eigen(const Eigen3& e);

/// True when all eigenvalues are positive and finite (leading minors in exact sign order).
bool is_positive_definite(const SymTensor& a);

/// log M by eigen-decomposition; M must be positive definite.
LogMetric log_of(const Metric& m);
/// exp L by eigen-decomposition: the accurate one, for anisotropy beyond what exp_fast serves.
Metric exp_exact(const LogMetric& l);
/// exp L by its series, beyond moderate anisotropy in closed form (eigenvalues by the trigonometric formula,
/// Newton's divided differences), and exp_exact beyond condition 1e10; the error is below 1e-13 times the
/// largest eigenvalue.
Metric exp_fast(const LogMetric& l);

/// Length of edge v between ends whose metrics measure it as la and lb: the exact integral for a
/// size that varies geometrically, (la-lb)/ln(la/lb), the mean when |la-lb| <= 0.001.
inline double log_mean_length(double la, double lb) {
  const double d = la - lb;
  return std::abs(d) > 0.001 ? d / std::log(la / lb) : 0.5 * (la + lb);
}
/// Edge length from its end metrics, the exact formula that reports use.
inline double edge_length(const Vec& v, const Metric& ma, const Metric& mb) {
  return log_mean_length(std::sqrt(squared_length(ma, v)), std::sqrt(squared_length(mb, v)));
}
/// The same within 0.2 % for end ratios up to 4, without a logarithm: (2G + A)/3 of the end lengths, which
/// are given squared.
inline double edge_length_of_squares(double sa, double sb) {
  const double la = std::sqrt(sa), lb = std::sqrt(sb);
  return (2 * std::sqrt(la * lb) + 0.5 * (la + lb)) * (1.0 / 3.0);
}
inline double edge_length_fast(const Vec& v, const Metric& ma, const Metric& mb) {
  return edge_length_of_squares(squared_length(ma, v), squared_length(mb, v));
}

/// 36 / 3^(1/3): makes the mean ratio of a regular tet 1.
inline constexpr double kMeanRatioFactor = 24.96100587662285;

/// Limits sizes to [hmin, hmax]: eigenvalues clamped to [hmax^-2, hmin^-2]. Zero means no limit.
Metric limit_sizes(const Metric& m, double hmin, double hmax);
/// Metric intersection by simultaneous reduction: at least as fine as both in every direction.
Metric intersect(const Metric& a, const Metric& b);

/// An analytic metric by name: `polar-1`, `polar-2`, `linear` (UGAWG adapt-benchmarks) or
/// `uniform:H`. Throws InputError for an unknown name.
class AnalyticMetric {
 public:
  explicit AnalyticMetric(const std::string& name);
  Metric operator()(const Point& p) const;

 private:
  enum class Kind { polar1, polar2, linear, uniform };
  Kind kind_;
  double h_ = 0;
};

}  // namespace weft::meshing

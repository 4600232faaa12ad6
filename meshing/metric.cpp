// Eigen-decomposition, logarithm and exponential of metrics; analytic metrics.
#include "meshing/metric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <string_view>

#include "meshing/error.h"

namespace weft::meshing {
namespace {

Eigen::Matrix3d to_eigen(const SymTensor& a) {
  Eigen::Matrix3d m;
  m << a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz;
  return m;
}

SymTensor from_matrix(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(1, 1), m(0, 2), m(1, 2), m(2, 2)};
}

template <class F>
SymTensor map_eigenvalues(const SymTensor& a, F f) {
  Eigen3 e = eigen_decomposition(a);
  for (double& v : e.values) v = f(v);
  return from_eigen(e);
}

/// A squared for a symmetric A, which is symmetric again.
SymTensor square(const SymTensor& a) {
  return {a.xx * a.xx + a.xy * a.xy + a.xz * a.xz, a.xx * a.xy + a.xy * a.yy + a.xz * a.yz,
          a.xy * a.xy + a.yy * a.yy + a.yz * a.yz, a.xx * a.xz + a.xy * a.yz + a.xz * a.zz,
          a.xy * a.xz + a.yy * a.yz + a.yz * a.zz, a.xz * a.xz + a.yz * a.yz + a.zz * a.zz};
}

/// (exp(a) - exp(b)) / (a - b) given exp(b), without cancellation.
double exp_divided_difference(double a, double b, double exp_b) {
  const double d = a - b;
  return std::abs(d) < 1e-8 ? exp_b * (1 + 0.5 * d) : exp_b * std::expm1(d) / d;
}

}  // namespace

Eigen3 eigen_decomposition(const SymTensor& a) {
  // Scaling by the largest entry keeps huge and tiny metrics away from overflow inside the iteration.
  const double scale = std::max({std::abs(a.xx), std::abs(a.xy), std::abs(a.yy), std::abs(a.xz),
                                 std::abs(a.yz), std::abs(a.zz), std::numeric_limits<double>::min()});
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(to_eigen((1 / scale) * a));
  Eigen3 e;
  for (int i = 0; i < 3; ++i) {
    e.values[i] = scale * solver.eigenvalues()[i];
    const auto v = solver.eigenvectors().col(i);
    e.vectors[i] = {v[0], v[1], v[2]};
  }
  return e;
}

SymTensor from_eigen(const Eigen3& e) {
  SymTensor a;
  for (int i = 0; i < 3; ++i) {
    const Vec& v = e.vectors[i];
    a = a + e.values[i] * SymTensor{v.x * v.x, v.x * v.y, v.y * v.y, v.x * v.z, v.y * v.z, v.z * v.z};
  }
  return a;
}

bool is_positive_definite(const SymTensor& a) {
  const Eigen3 e = eigen_decomposition(a);
  return std::isfinite(trace(a)) && std::isfinite(a.xy + a.xz + a.yz) && e.values[0] > 0 &&
         std::isfinite(e.values[2]);
}

LogMetric log_of(const Metric& m) {
  return map_eigenvalues(m, [](double v) { return std::log(v); });
}

Metric exp_exact(const LogMetric& l) {
  return map_eigenvalues(l, [](double v) { return std::exp(v); });
}

Metric exp_fast(const LogMetric& l) {
  const double mean = trace(l) / 3;
  const SymTensor a = l - identity_tensor(mean);
  const SymTensor a2 = square(a);
  const double p = std::sqrt(trace(a2) / 6);
  if (p < 1e-7) return std::exp(mean) * (identity_tensor() + a + 0.5 * a2);
  const double half_det = 0.5 * determinant(a) / (p * p * p);
  const double phi = std::acos(std::clamp(half_det, -1.0, 1.0)) / 3;
  const double c = std::cos(phi), s = 0.86602540378443865 * std::sqrt(std::max(0.0, 1 - c * c));
  const double e1 = 2 * p * c, e3 = p * (-c - 2 * s), e2 = -e1 - e3;
  if (e1 - e3 > 23) return exp_exact(l);
  const double f3 = std::exp(mean + e3), f2 = std::exp(mean + e2);
  const double d12 = exp_divided_difference(e1, e2, f2), d23 = exp_divided_difference(e2, e3, f3);
  const double d123 = (d12 - d23) / (e1 - e3);
  // Newton's form at the nodes e3, e2, e1: f3 + d23 (A - e3) + d123 (A - e3)(A - e2).
  const double c0 = f3 - d23 * e3 + d123 * e3 * e2, c1 = d23 - d123 * (e3 + e2);
  return identity_tensor(c0) + c1 * a + d123 * a2;
}

Metric limit_sizes(const Metric& m, double hmin, double hmax) {
  const double hi = hmin > 0 ? 1 / (hmin * hmin) : std::numeric_limits<double>::infinity();
  const double lo = hmax > 0 ? 1 / (hmax * hmax) : 0;
  return map_eigenvalues(m, [=](double v) { return std::clamp(v, lo, hi); });
}

Metric intersect(const Metric& a, const Metric& b) {
  // Simultaneous reduction through the Cholesky factor of a: in that frame a is the identity and b is
  // diagonalised.
  const Eigen::LLT<Eigen::Matrix3d> factor(to_eigen(a));
  const auto lower = factor.matrixL();
  const Eigen::Matrix3d half = lower.solve(to_eigen(b));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> e(lower.solve(half.transpose()));
  const Eigen::Vector3d larger = e.eigenvalues().cwiseMax(1.0);
  const Eigen::Matrix3d p = lower * e.eigenvectors();
  return from_matrix(p * larger.asDiagonal() * p.transpose());
}

AnalyticMetric::AnalyticMetric(const std::string& name) {
  constexpr std::string_view kUniform = "uniform:";
  if (name == "polar-1") {
    kind_ = Kind::polar1;
  } else if (name == "polar-2") {
    kind_ = Kind::polar2;
  } else if (name == "linear") {
    kind_ = Kind::linear;
  } else if (name.starts_with(kUniform)) {
    kind_ = Kind::uniform;
    try {
      std::size_t used = 0;
      h_ = std::stod(name.substr(kUniform.size()), &used);
      if (used + kUniform.size() != name.size()) h_ = 0;
    } catch (const std::exception&) {
      h_ = 0;
    }
    if (!(h_ > 0) || !std::isfinite(h_))
      throw InputError("", "metric " + name, "the size H must be a positive number");
  } else {
    throw InputError("", "metric " + name, "unknown; known are polar-1, polar-2, linear and uniform:H");
  }
}

Metric AnalyticMetric::operator()(const Point& p) const {
  constexpr double h0 = 0.001;
  if (kind_ == Kind::uniform) return identity_tensor(1 / (h_ * h_));
  if (kind_ == Kind::linear) {
    const double hz = h0 + 2 * (0.1 - h0) * std::abs(p.z - 0.5);
    return {100, 0, 100, 0, 0, 1 / (hz * hz)};
  }
  const double r = std::hypot(p.x, p.y), from_layer = std::abs(r - 0.5);
  const double hr = h0 + 2 * (0.1 - h0) * from_layer;
  const double d = std::min(10 * from_layer, 1.0);
  const double ht = kind_ == Kind::polar1 ? 0.1 : 0.1 * d + 0.025 * (1 - d);
  const double c = r > 0 ? p.x / r : 1, s = r > 0 ? p.y / r : 0;
  const double mr = 1 / (hr * hr), mt = 1 / (ht * ht);
  return {mr * c * c + mt * s * s, (mr - mt) * c * s, mr * s * s + mt * c * c, 0, 0, 100};
}

}  // namespace weft::meshing

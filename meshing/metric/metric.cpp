// Eigen-decomposition, logarithm and exponential of metrics; analytic metrics.
#include "meshing/metric/metric.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace {

/// The number that a text is, whatever the locale; 0: it is none.
double size_named(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : 0;
}

Eigen::Matrix3d to_eigen(const SymTensor& a) {
  Eigen::Matrix3d m;
  m << a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz;
  return m;
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

/// A factor L of A = L L^T.
struct LowerTriangle {
  double xx, yx, yy, zx, zy, zz;
};

/// Cholesky's factor, with the roots last so that they do not wait for each other.
LowerTriangle cholesky(const SymTensor& a) {
  const double yx = a.xy / a.xx, zx = a.xz / a.xx;
  const double yy = a.yy - yx * a.xy, yz = a.yz - yx * a.xz;
  const double zy = yz / yy, zz = a.zz - zx * a.xz - zy * yz;
  const double x = std::sqrt(a.xx), y = std::sqrt(yy), z = std::sqrt(zz);
  return {x, yx * x, y, zx * x, zy * y, z};
}

/// L^-1 B L^-T.
SymTensor reduced(const LowerTriangle& l, const SymTensor& b) {
  const double rx = 1 / l.xx, ry = 1 / l.yy, rz = 1 / l.zz;
  const auto solved = [&](const Vec& c) {
    const double x = c.x * rx, y = (c.y - l.yx * x) * ry;
    return Vec{x, y, (c.z - l.zx * x - l.zy * y) * rz};
  };
  const Vec x = solved({b.xx, b.xy, b.xz}), y = solved({b.xy, b.yy, b.yz}), z = solved({b.xz, b.yz, b.zz});
  const Vec first = solved({x.x, y.x, z.x}), second = solved({x.y, y.y, z.y}),
            third = solved({x.z, y.z, z.z});
  return {first.x, first.y, second.y, first.z, second.z, third.z};
}

/// L P L^T.
SymTensor expanded(const LowerTriangle& l, const SymTensor& p) {
  const Vec x{l.xx, 0, 0}, y{l.yx, l.yy, 0}, z{l.zx, l.zy, l.zz};
  const Vec px = apply(p, x), py = apply(p, y), pz = apply(p, z);
  return {dot(x, px), dot(x, py), dot(y, py), dot(x, pz), dot(y, pz), dot(z, pz)};
}

/// cos(arccos(x) / 3): a polynomial in cos(arccos(x) / 2) that is right to 1e-4, and two of Newton's steps.
double cos_third(double x) {
  const double u = std::sqrt(0.5 + 0.5 * x);
  double t = 1 + u * (1.154588 + u * (-0.218549 + u * (0.086351 - 0.022457 * u)));  // twice the result
  if (u < 1e-7) return 0.5 * t;  // the root of t^3 - 3 t = 2 x is nearly double
  for (int i = 0; i < 2; ++i) t -= (t * (t * t - 3) - 2 * x) / (3 * (t * t - 1));
  return 0.5 * t;
}

/// Eigenvalues of a deviator (trace 0), descending, by the trigonometric formula.
struct DeviatorValues {
  double e1, e2, e3;
  double error;  ///< of e2 and e3, or e1 and e2, as far as rounding goes; large where two nearly coincide
};
DeviatorValues deviator_values(const SymTensor& a, double p) {
  const double half_det = std::clamp(0.5 * determinant(a) / (p * p * p), -1.0, 1.0);
  const double c = cos_third(half_det), s = 0.86602540378443865 * std::sqrt(std::max(0.0, 1 - c * c));
  const double e1 = 2 * p * c, e3 = p * (-c - 2 * s);
  return {e1, -e1 - e3, e3, 1e-15 * p / std::sqrt(std::max(1 - half_det * half_det, 1e-30))};
}

/// A with its negative eigenvalues set to zero, by Newton's divided differences of max(x, 0) at the
/// eigenvalues, which are bounded however close these are; nothing where rounding would cost more than 1e-11.
std::optional<SymTensor> positive_part(const SymTensor& a) {
  constexpr double kRounding = 1e-11;
  const double mean = trace(a) / 3;
  const SymTensor d = a - identity_tensor(mean), d2 = square(d);
  const double p = std::sqrt(trace(d2) / 6);
  if (p < kRounding) return identity_tensor(std::max(mean, 0.0));
  const auto [e1, e2, e3, error] = deviator_values(d, p);
  if (mean + e3 >= 0) return a;
  if (mean + e1 <= 0) return SymTensor{};
  if (!(error < kRounding)) return std::nullopt;
  // f(e3) is 0 here, so that Newton's form begins with the slope between e3 and e2.
  const double f1 = mean + e1, f2 = std::max(mean + e2, 0.0);
  const double d23 = f2 > 0 ? f2 / (e2 - e3) : 0, d12 = f2 > 0 ? 1 : f1 / (e1 - e2);
  const double d123 = (d12 - d23) / (e1 - e3);
  return identity_tensor(d123 * e3 * e2 - d23 * e3) + (d23 - d123 * (e3 + e2)) * d + d123 * d2;
}

/// exp(mean I + A) of a symmetric A without trace and with a norm up to kMostBySeries; `a2` is its square. By
/// Cayley and Hamilton A^3 = s A + d I, so that all powers are sums u I + v A + w A^2: the series of a
/// 64th of A is summed and squared six times in these three numbers (half the time of the closed form).
constexpr double kMostBySeries = 10;
Metric exp_by_series(double mean, const SymTensor& a, const SymTensor& a2) {
  constexpr int kSquarings = 6;  // the first term left out is below 1e-16
  constexpr double kShare = 1.0 / (1 << kSquarings);
  const double s = 0.5 * kShare * kShare * trace(a2), d = kShare * kShare * kShare * determinant(a);
  double p = 1, q = 1, r = 0.5;  // the sum
  double u = 0, v = 0, w = 0.5;  // its last term
  for (const double share : {1.0 / 3, 1.0 / 4, 1.0 / 5, 1.0 / 6, 1.0 / 7, 1.0 / 8, 1.0 / 9, 1.0 / 10}) {
    const double of_identity = w * d, of_a = u + w * s;
    w = share * v, u = share * of_identity, v = share * of_a;
    p += u, q += v, r += w;
  }
  for (int i = 0; i < kSquarings; ++i) {
    const double qr = 2 * q * r, rr = r * r;
    r = 2 * p * r + q * q + rr * s;
    q = 2 * p * q + qr * s + rr * d;
    p = p * p + qr * d;
  }
  const double scale = std::exp(mean);
  return identity_tensor(scale * p) + (scale * kShare * q) * a + (scale * kShare * kShare * r) * a2;
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
  if (trace(a2) <= kMostBySeries * kMostBySeries) return exp_by_series(mean, a, a2);
  const double p = std::sqrt(trace(a2) / 6);
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
  // Simultaneous reduction through the Cholesky factor L of a: there a is the identity, b is I + C, and the
  // intersection I + the positive part of C.
  const LowerTriangle l = cholesky(a);
  const SymTensor c = reduced(l, b) - identity_tensor();
  const std::optional<SymTensor> more = positive_part(c);
  return a + expanded(l, more ? *more : map_eigenvalues(c, [](double v) { return std::max(v, 0.0); }));
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
    h_ = size_named(std::string_view(name).substr(kUniform.size()));
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

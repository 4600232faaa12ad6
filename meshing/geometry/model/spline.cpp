// Bernstein polynomials, their combinations to basis functions, and sums over control points.
#include "meshing/geometry/model/spline.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>

namespace weft::meshing {
namespace {

// GCC's portable vectors, as in lanes.h.
typedef double FourLanes __attribute__((vector_size(32)));

FourLanes load_four(const double* p) {
  FourLanes v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
Point point_of(const FourLanes& v) { return {v[0], v[1], v[2]}; }

constexpr std::size_t kOrders = kMostSplineDegree + 1;

/// n over k, row n.
constexpr std::array<std::array<double, kOrders>, kOrders> make_binomials() {
  std::array<std::array<double, kOrders>, kOrders> c{};
  for (std::size_t n = 0; n < kOrders; ++n) {
    c[n][0] = 1;
    for (std::size_t k = 1; k <= n; ++k) c[n][k] = c[n - 1][k - 1] + c[n - 1][k];
  }
  return c;
}
constexpr auto kBinomials = make_binomials();

/// Values of the Bernstein polynomials of `degree` at s in [0, 1] and their first two derivatives by the
/// parameter, of which the span has the length `length`.
void evaluate_bernstein(std::size_t degree, double s, double length, double (&d)[3][kOrders + 2]) {
  double power[kOrders], rest_power[kOrders];
  power[0] = rest_power[0] = 1;
  for (std::size_t i = 1; i <= degree; ++i) {
    power[i] = power[i - 1] * s;
    rest_power[i] = rest_power[i - 1] * (1 - s);
  }
  for (std::size_t i = 0; i <= degree; ++i)
    d[0][i] = kBinomials[degree][i] * power[i] * rest_power[degree - i];
  // Derivatives are differences of the polynomials of lower degree, which stand between zeros.
  double lower[kOrders + 3];
  const double slope = static_cast<double>(degree) / length;
  lower[0] = lower[degree + 1] = 0;
  for (std::size_t i = 0; i < degree; ++i)
    lower[i + 1] = slope * kBinomials[degree - 1][i] * power[i] * rest_power[degree - 1 - i];
  for (std::size_t i = 0; i <= degree; ++i) d[1][i] = lower[i] - lower[i + 1];
  if (degree < 2) {
    for (std::size_t i = 0; i <= degree; ++i) d[2][i] = 0;
    return;
  }
  const double bend = slope * static_cast<double>(degree - 1) / length;
  lower[0] = lower[1] = lower[degree + 1] = lower[degree + 2] = 0;
  for (std::size_t i = 0; i + 1 < degree; ++i)
    lower[i + 2] = bend * kBinomials[degree - 2][i] * power[i] * rest_power[degree - 2 - i];
  for (std::size_t i = 0; i <= degree; ++i) d[2][i] = lower[i] - 2 * lower[i + 1] + lower[i + 2];
}

/// The k-th Bernstein coefficient on the span [knots[span], knots[span + 1]] of a basis function, counted
/// among those that are not zero there: its blossom with k arguments at the span's end and the others at its
/// begin, by de Boor's algorithm.
double bernstein_coefficient(const SplineKnots& s, std::size_t span, std::size_t function, std::size_t k) {
  const auto p = static_cast<std::size_t>(s.degree);
  double d[kOrders] = {};
  d[function] = 1;
  for (std::size_t r = 1; r <= p; ++r) {
    const double x = s.knots[r <= k ? span + 1 : span];
    for (std::size_t j = p; j >= r; --j) {
      const double lower = s.knots[span + j - p], upper = s.knots[span + j + 1 - r];
      const double share = (x - lower) / (upper - lower);
      d[j] = (1 - share) * d[j - 1] + share * d[j];
    }
  }
  return d[p];
}

}  // namespace

SplineBasis::SplineBasis(const SplineKnots& knots)
    : degree_(static_cast<std::size_t>(knots.degree)),
      num_control_(knots.knots.size() - degree_ - 1),
      stride_((degree_ + 4) / 4 * 4) {
  for (std::size_t i = degree_; i < num_control_; ++i) {
    if (!(knots.knots[i] < knots.knots[i + 1])) continue;
    breaks_.push_back(knots.knots[i]);
    first_.push_back(i - degree_);
    for (std::size_t k = 0; k <= degree_; ++k) {
      extraction_.resize(extraction_.size() + stride_);
      double* const row = extraction_.data() + extraction_.size() - stride_;
      for (std::size_t f = 0; f <= degree_; ++f) {
        row[f] = bernstein_coefficient(knots, i, f, k);
        is_bezier_ = is_bezier_ && row[f] == (f == k ? 1 : 0);
      }
    }
  }
  breaks_.push_back(knots.knots[num_control_]);
}

void SplineBasis::evaluate(double t, Values& values) const {
  const auto inner = std::span(breaks_).subspan(1, breaks_.size() - 2);
  const auto span = static_cast<std::size_t>(std::upper_bound(inner.begin(), inner.end(), t) - inner.begin());
  const double begin = breaks_[span], length = breaks_[span + 1] - begin;
  values.first = first_[span];
  if (is_bezier_) return evaluate_bernstein(degree_, (t - begin) / length, length, values.d);
  double bernstein[3][kOrders + 2];
  evaluate_bernstein(degree_, (t - begin) / length, length, bernstein);
  const double* const rows = extraction_.data() + span * (degree_ + 1) * stride_;
  for (std::size_t j = 0; j < stride_; j += 4) {
    FourLanes sum[3] = {};
    for (std::size_t k = 0; k <= degree_; ++k) {
      const FourLanes share = load_four(rows + k * stride_ + j);
      for (int i = 0; i < 3; ++i) sum[i] += bernstein[i][k] * share;
    }
    for (int i = 0; i < 3; ++i) std::memcpy(values.d[i] + j, &sum[i], sizeof sum[i]);
  }
}

SplineCurve::SplineCurve(const CurveSpline& data) : basis_(data.knots), control_(data.control) {}

CurveJet SplineCurve::evaluate(double t) const {
  SplineBasis::Values n;
  basis_.evaluate(t, n);
  FourLanes x{}, d1{}, d2{};
  for (std::size_t i = 0; i <= basis_.degree(); ++i) {
    const FourLanes c = load_four(control_[n.first + i].data());
    x += n.d[0][i] * c;
    d1 += n.d[1][i] * c;
    d2 += n.d[2][i] * c;
  }
  // The quotient by the weight, the last number, and its derivatives.
  const double w = 1 / x[3], w1 = d1[3], w2 = d2[3];
  x *= w;
  d1 = w * (d1 - w1 * x);
  d2 = w * (d2 - 2 * w1 * d1 - w2 * x);
  return {point_of(x), point_of(d1), point_of(d2)};
}

SplineSurface::SplineSurface(const SurfaceSpline& data)
    : turned_(data.knots[0].degree > data.knots[1].degree),
      outer_(data.knots[turned_ ? 1 : 0]),
      inner_(data.knots[turned_ ? 0 : 1]),
      control_(data.control) {
  if (!turned_) return;
  const std::size_t rows = outer_.num_control(), columns = inner_.num_control();
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) control_[i * columns + j] = data.control[j * rows + i];
}

SurfaceJet SplineSurface::evaluate(const Parameters& at) const {
  SplineBasis::Values m, n;
  outer_.evaluate(at[turned_ ? 1 : 0], m);
  inner_.evaluate(at[turned_ ? 0 : 1], n);
  FourLanes x{}, du{}, dv{}, duu{}, duv{}, dvv{};
  for (std::size_t i = 0; i <= outer_.degree(); ++i) {
    const WeightedPoint* const row = control_.data() + (m.first + i) * inner_.num_control() + n.first;
    FourLanes r{}, rv{}, rvv{};
    for (std::size_t j = 0; j <= inner_.degree(); ++j) {
      const FourLanes c = load_four(row[j].data());
      r += n.d[0][j] * c;
      rv += n.d[1][j] * c;
      rvv += n.d[2][j] * c;
    }
    x += m.d[0][i] * r;
    du += m.d[1][i] * r;
    duu += m.d[2][i] * r;
    dv += m.d[0][i] * rv;
    duv += m.d[1][i] * rv;
    dvv += m.d[0][i] * rvv;
  }
  // The quotient by the weight, the last number, and its derivatives.
  const double w = 1 / x[3], wu = du[3], wv = dv[3], wuu = duu[3], wuv = duv[3], wvv = dvv[3];
  x *= w;
  du = w * (du - wu * x);
  dv = w * (dv - wv * x);
  duu = w * (duu - 2 * wu * du - wuu * x);
  duv = w * (duv - wu * dv - wv * du - wuv * x);
  dvv = w * (dvv - 2 * wv * dv - wvv * x);
  if (turned_) std::swap(du, dv), std::swap(duu, dvv);
  return {point_of(x), point_of(du), point_of(dv), point_of(duu), point_of(duv), point_of(dvv)};
}

}  // namespace weft::meshing

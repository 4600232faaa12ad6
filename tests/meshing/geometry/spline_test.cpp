// B-splines and NURBS against polynomials, circles and quadrics that they are.
#include "meshing/geometry/model/spline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace weft::meshing::spline_test {
namespace {

WeightedPoint weighted(const Point& p, double weight = 1) {
  return {weight * p.x, weight * p.y, weight * p.z, weight};
}

/// Marsden's identity: with these control points the curve is (t, t^2, 1), whatever the knots are.
CurveSpline parabola(int degree, const std::vector<double>& knots) {
  CurveSpline spline{{degree, knots}, {}};
  const auto p = static_cast<std::size_t>(degree);
  for (std::size_t i = 0; i + p + 1 < knots.size(); ++i) {
    double sum = 0, products = 0;
    for (std::size_t j = 1; j <= p; ++j)
      for (std::size_t k = j + 1; k <= p; ++k) products += knots[i + j] * knots[i + k];
    for (std::size_t j = 1; j <= p; ++j) sum += knots[i + j];
    const double n = degree;
    spline.control.push_back(weighted({sum / n, products / (n * (n - 1) / 2), 1}));
  }
  return spline;
}

TEST(Spline, OfAParabolaIsTheParabolaForAnyKnots) {
  const std::vector<CurveSpline> splines = {
      parabola(2, {0, 0, 0, 1, 1, 1}), parabola(3, {0, 0, 0, 0, 0.2, 0.7, 0.7, 1, 1, 1, 1}),
      parabola(4, {-0.4, -0.3, -0.1, -0.1, 0, 0.5, 1, 1.2, 1.5, 1.6, 2}),
      parabola(5, {0, 0, 0, 0, 0, 0, 1e-9, 0.3, 0.3, 0.3, 0.3, 1, 1, 1, 1, 1, 1})};
  for (const CurveSpline& data : splines) {
    const SplineCurve curve(data);
    EXPECT_EQ(curve.first(), 0);
    EXPECT_EQ(curve.last(), 1);
    for (const double t : {0.0, 1e-10, 0.1, 0.2, 0.3, 0.5, 0.7, 0.99, 1.0}) {
      const CurveJet jet = curve.evaluate(t);
      EXPECT_NEAR(norm(jet.x - Point{t, t * t, 1}), 0, 2e-15) << data.knots.degree << " at " << t;
      // On a span of 1e-9 rounding is divided by that, and by its square.
      EXPECT_NEAR(norm(jet.d1 - Vec{1, 2 * t, 0}), 0, t < 1e-9 ? 1e-5 : 1e-13) << t;
      EXPECT_NEAR(norm(jet.d2 - Vec{0, 2, 0}), 0, t < 1e-9 ? 1e5 : 1e-11) << t;
    }
  }
}

/// A quarter of the unit circle.
CurveSpline quarter() {
  return {{2, {0, 0, 0, 1, 1, 1}},
          {weighted({1, 0, 0}), weighted({1, 1, 0}, std::sqrt(0.5)), weighted({0, 1, 0})}};
}

TEST(Spline, WithWeightsIsACircle) {
  const SplineCurve curve(quarter());
  for (int i = 0; i <= 20; ++i) {
    const double t = i / 20.0;
    const CurveJet jet = curve.evaluate(t);
    EXPECT_NEAR(norm(jet.x), 1, 1e-15);
    EXPECT_NEAR(dot(jet.x, jet.d1), 0, 1e-15);
    EXPECT_NEAR(dot(jet.x, jet.d2), -norm2(jet.d1), 1e-14);
    const double h = 1e-5;
    EXPECT_NEAR(norm((0.5 / h) * (curve.evaluate(t + h).x - curve.evaluate(t - h).x) - jet.d1), 0, 1e-9);
  }
}

/// The quarter turned around z into an eighth of a sphere, degree 2 in both, or with the degree raised in u.
SurfaceSpline eighth() {
  SurfaceSpline s;
  s.knots = {SplineKnots{2, {0, 0, 0, 1, 1, 1}}, SplineKnots{2, {0, 0, 0, 1, 1, 1}}};
  const double w = std::sqrt(0.5);
  const std::vector<Point> around = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<std::array<double, 2>> meridian = {{1, 0}, {1, 1}, {0, 1}};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      s.control.push_back(
          weighted({meridian[j][0] * around[i].x, meridian[j][0] * around[i].y, meridian[j][1]},
                   (i == 1 ? w : 1) * (j == 1 ? w : 1)));
  return s;
}

/// Degree 3 in u, which is the higher then.
SurfaceSpline raised_in_u(const SurfaceSpline& s) {
  SurfaceSpline r;
  r.knots = {SplineKnots{3, {0, 0, 0, 0, 1, 1, 1, 1}}, s.knots[1]};
  r.control.resize(12);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 4; ++k) {
        const double share = static_cast<double>(i) / 3;
        if (i > 0) r.control[3 * i + j][k] += share * s.control[3 * (i - 1) + j][k];
        if (i < 3) r.control[3 * i + j][k] += (1 - share) * s.control[3 * i + j][k];
      }
  return r;
}

TEST(Spline, SurfaceOfASphereHasItsPointsAndDerivatives) {
  for (const SurfaceSpline& data : {eighth(), raised_in_u(eighth())}) {
    const SplineSurface surface(data);
    const SurfaceJet corner = surface.evaluate({1, 0});
    EXPECT_NEAR(norm(corner.x - Point{0, 1, 0}), 0, 1e-15);
    for (int i = 1; i < 10; ++i)
      for (int j = 1; j < 10; ++j) {
        const double u = i / 10.0, v = j / 10.0, h = 1e-5;
        const SurfaceJet jet = surface.evaluate({u, v});
        const auto x = [&](double a, double b) { return surface.evaluate({u + a * h, v + b * h}).x; };
        EXPECT_NEAR(norm(jet.x), 1, 1e-15);
        EXPECT_NEAR(norm((0.5 / h) * (x(1, 0) - x(-1, 0)) - jet.du), 0, 1e-9);
        EXPECT_NEAR(norm((0.5 / h) * (x(0, 1) - x(0, -1)) - jet.dv), 0, 1e-9);
        // Of |x|^2 = 1: second derivatives against first ones.
        EXPECT_NEAR(dot(jet.x, jet.duu), -norm2(jet.du), 1e-14);
        EXPECT_NEAR(dot(jet.x, jet.duv), -dot(jet.du, jet.dv), 1e-14);
        EXPECT_NEAR(dot(jet.x, jet.dvv), -norm2(jet.dv), 1e-14);
        EXPECT_NEAR(norm((0.25 / (h * h)) * (x(1, 1) + x(-1, -1) - x(1, -1) - x(-1, 1)) - jet.duv), 0, 1e-4);
      }
  }
}

TEST(Spline, AtAKnotIsTheSpanAfterIt) {
  // A bend of degree 1.
  const SplineCurve bent(
      CurveSpline{{1, {0, 0, 1, 2, 2}}, {weighted({0, 0, 0}), weighted({1, 0, 0}), weighted({1, 3, 0})}});
  EXPECT_EQ(bent.evaluate(0.999).d1.y, 0);
  EXPECT_EQ(bent.evaluate(1).d1.y, 3);
  EXPECT_EQ(bent.evaluate(2).d1.y, 3);
  EXPECT_EQ(bent.evaluate(2).x.y, 3);
}

}  // namespace
}  // namespace weft::meshing::spline_test

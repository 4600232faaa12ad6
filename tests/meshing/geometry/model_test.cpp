// Closest points, curvature and borders of models, with formulas and without.
#include "meshing/geometry/model/model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "meshing/geometry/model/analytic_model.h"

namespace weft::meshing::model_test {
namespace {

constexpr double kPi = std::numbers::pi;

Point random_point(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> in(-size, size);
  return {in(random), in(random), in(random)};
}

/// Derivatives against differences of values.
TEST(ClosedForms, HaveTheDerivativesOfTheirValues) {
  using Kind = SurfaceForm::Kind;
  const Frame frame{{1, 2, 3}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  for (const SurfaceForm& form :
       {SurfaceForm{Kind::plane, frame, 0, 0}, SurfaceForm{Kind::cylinder, frame, 2, 0},
        SurfaceForm{Kind::cone, frame, 2, 0.3}, SurfaceForm{Kind::sphere, frame, 2, 0},
        SurfaceForm{Kind::torus, frame, 2, 0.5}}) {
    const double u = 0.7, v = 0.4, h = 1e-5;
    const SurfaceJet jet = evaluate(form, {u, v});
    const auto x = [&](double a, double b) { return evaluate(form, {u + a * h, v + b * h}).x; };
    EXPECT_NEAR(norm((1 / (2 * h)) * (x(1, 0) - x(-1, 0)) - jet.du), 0, 1e-8);
    EXPECT_NEAR(norm((1 / (2 * h)) * (x(0, 1) - x(0, -1)) - jet.dv), 0, 1e-8);
    EXPECT_NEAR(norm((1 / (h * h)) * (x(1, 0) + x(-1, 0) - 2 * x(0, 0)) - jet.duu), 0, 1e-4);
    EXPECT_NEAR(norm((1 / (h * h)) * (x(0, 1) + x(0, -1) - 2 * x(0, 0)) - jet.dvv), 0, 1e-4);
    EXPECT_NEAR(norm((1 / (4 * h * h)) * (x(1, 1) + x(-1, -1) - x(1, -1) - x(-1, 1)) - jet.duv), 0, 1e-4);
    const Vec n = unit_normal(form, {u, v});
    EXPECT_NEAR(norm(n), 1, 1e-14);
    EXPECT_NEAR(dot(n, cross(jet.du, jet.dv)), norm(cross(jet.du, jet.dv)), 1e-12);
    const Point p = jet.x + 0.1 * n;
    const Parameters back = closest_parameters(form, p);
    EXPECT_NEAR(norm(evaluate(form, back).x - jet.x), 0, 1e-14);
  }
}

TEST(Model, FindsOnASphereTheClosestPoint) {
  const Model model(ball_model({1, 0, -1}, 2));
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const Point p = random_point(random, 5);
    const OnFace q = model.closest_on_face(0, p);
    EXPECT_NEAR(norm(q.x - Point{1, 0, -1}), 2, 1e-14);
    EXPECT_NEAR(q.distance, std::abs(norm(p - Point{1, 0, -1}) - 2), 1e-13);
    EXPECT_NEAR(norm(cross(q.normal, p - q.x)), 0, 1e-12);
  }
}

TEST(Model, WithoutFormulasFindsTheSameClosestPoints) {
  for (const auto& geometry : {ball_model({1, 0, -1}, 2), frustum_model({}, 1, 0.5, 2)}) {
    const Model exact(geometry), searched(without_formulas(geometry));
    std::mt19937 random(4);
    for (int i = 0; i < 200; ++i) {
      const Point p = random_point(random, 3);
      EXPECT_NEAR(searched.closest_on_face(0, p).distance, exact.closest_on_face(0, p).distance, 1e-12);
      if (exact.num_edges() > 0) {
        EXPECT_NEAR(searched.closest_on_edge(0, p).distance, exact.closest_on_edge(0, p).distance, 1e-12);
      }
    }
  }
}

TEST(Model, FromAGuessAcrossTheSeamFindsTheClosestPoint) {
  const Model model(without_formulas(frustum_model({}, 1, 1, 2)));
  const Point p{1.1 * std::cos(0.05), -1.1 * std::sin(0.05), 1};
  const OnFace q = model.closest_on_face(0, p, {0.02, 1});
  EXPECT_NEAR(q.distance, 0.1, 1e-14);
  EXPECT_NEAR(model.wrapped(0, q.at)[0], 2 * kPi - 0.05, 1e-10);
}

TEST(Model, AtThePoleOfASphereWithoutFormulasComesToRest) {
  const Model model(without_formulas(ball_model({}, 1)));
  for (const Point& p : {Point{0, 0, 1}, Point{0, 0, 1.5}, Point{1e-9, 0, 1}, Point{1e-4, -1e-4, 0.9}}) {
    EXPECT_NEAR(model.closest_on_face(0, p).distance, std::abs(norm(p) - 1), 1e-9);
    EXPECT_NEAR(model.closest_on_face(0, p, {2, kPi / 2 - 0.1}).distance, std::abs(norm(p) - 1), 1e-9);
  }
}

TEST(Model, BeyondTheApexOfAConeFindsTheApex) {
  const Model model(frustum_model({}, 1, 0, 1));
  EXPECT_NEAR(norm(model.closest_on_face(0, {0, 0, 2}).x - Point{0, 0, 1}), 0, 1e-15);
}

TEST(Model, KnowsWhatLiesWithinTheBorderOfAFace) {
  const Model model(frustum_model({}, 1, 1, 2));
  EXPECT_TRUE(model.is_inside(0, {3, 1}));
  EXPECT_TRUE(model.is_inside(0, {-3, 1}));
  EXPECT_FALSE(model.is_inside(0, {3, 2.5}));
  EXPECT_TRUE(model.is_inside(1, {0.2, 0.3}));
  EXPECT_FALSE(model.is_inside(1, {0.9, 0.9}));
  EXPECT_NEAR(model.closest_within(0, {2, 0, 3}).distance, std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(model.closest_within(1, {2, 0, 0}).distance, 1, 1e-14);
}

TEST(Model, KeepsAnArcsParameterInItsRange) {
  const Model model(frustum_model({}, 1, 1, 2));
  const OnEdge q = model.closest_on_edge(0, {0, -3, 0});
  EXPECT_NEAR(q.t, 1.5 * kPi, 1e-14);
  EXPECT_NEAR(norm(q.x - Point{0, -1, 0}), 0, 1e-15);
  EXPECT_NEAR(model.closest_on_edge(2, {5, 0, 7}).t, 2, 1e-15);
}

TEST(Model, HasTheCurvatureOfASphereAndOfACylinder) {
  const Model ball(ball_model({}, 2)), tube(frustum_model({}, 0.5, 0.5, 2));
  const auto at_ball = ball.curvature(0, {0.3, 0.4});
  ASSERT_TRUE(at_ball);
  EXPECT_NEAR(at_ball->largest, -0.5, 1e-12);
  EXPECT_NEAR(at_ball->least, -0.5, 1e-12);
  const auto at_tube = tube.curvature(0, {0.3, 0.4});
  ASSERT_TRUE(at_tube);
  EXPECT_NEAR(at_tube->largest, 0, 1e-12);
  EXPECT_NEAR(at_tube->least, -2, 1e-12);
  EXPECT_NEAR(std::abs(at_tube->direction.z), 1, 1e-12);
  EXPECT_FALSE(ball.curvature(0, {0.3, kPi / 2}));
}

TEST(Model, HasDetailByTheSizeAndTheCurvatureOfFaces) {
  // A ball's diagonal is 3.5 radii, of its box a tenth more: 1 % of the radius is the most that is asked.
  EXPECT_NEAR(Model(ball_model({}, 2)).detail(0), 0.02, 1e-12);
  EXPECT_NEAR(Model(ball_model({}, 2), 10).detail(0), 0.2, 1e-11);
  // A needle: 5 % of its radius, but no less than a 5,000th of its length.
  EXPECT_NEAR(Model(frustum_model({}, 0.01, 0.01, 1)).detail(0), 5e-4, 1e-12);
  EXPECT_NEAR(Model(frustum_model({}, 0.001, 0.001, 1)).detail(0), 2e-4, 3e-5);
}

TEST(Model, ScaledHasLengthsOfItsScaleAndParametersOfItsOwn) {
  for (const auto& geometry :
       {frustum_model({1, 2, 3}, 1, 0.5, 2), without_formulas(frustum_model({1, 2, 3}, 1, 0.5, 2))}) {
    const Model model(geometry), scaled(geometry, 0.001);
    EXPECT_NEAR(scaled.size(), 0.001 * model.size(), 1e-15);
    const Point p{2.2, 2.3, 4};
    const OnFace q = model.closest_on_face(0, p), s = scaled.closest_on_face(0, 0.001 * p);
    EXPECT_NEAR(s.distance, 0.001 * q.distance, 1e-15);
    EXPECT_NEAR(s.at[0], q.at[0], 1e-9);
    EXPECT_NEAR(s.at[1], q.at[1], 1e-9);
  }
}

}  // namespace
}  // namespace weft::meshing::model_test

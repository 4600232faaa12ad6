// The projection.
#include "tools/picture/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace weft::picture::camera_test {
namespace {

using meshing::Point;
using meshing::Vec;

std::vector<Point> random_points(std::mt19937& random, int n) {
  std::uniform_real_distribution<double> coordinate(-3, 5);
  std::vector<Point> points;
  for (int i = 0; i < n; ++i) points.push_back({coordinate(random), coordinate(random), coordinate(random)});
  return points;
}

View view_named(const std::string& name) {
  const Vec eye = direction_named(name);
  return {eye, default_up(eye)};
}

TEST(Camera, SeesTheAxesWhereTheyAreDrawnOnPaper) {
  struct Case {
    const char* name;
    Vec right, up;
  };
  for (const auto& [name, right, up] :
       {Case{"x", {0, 1, 0}, {0, 0, 1}}, Case{"-x", {0, -1, 0}, {0, 0, 1}}, Case{"-y", {1, 0, 0}, {0, 0, 1}},
        Case{"z", {1, 0, 0}, {0, 1, 0}}, Case{"-90,0", {1, 0, 0}, {0, 0, 1}}}) {
    const Camera camera(view_named(name), {}, 10, 10);
    EXPECT_NEAR(camera.turn(right).x, 1, 1e-12) << name;
    EXPECT_NEAR(camera.turn(up).y, -1, 1e-12) << name;
    EXPECT_NEAR(camera.turn(direction_named(name)).depth, -1, 1e-12) << name;
  }
}

TEST(Camera, IsometricViewShortensTheAxesAlike) {
  const Camera camera(view_named("iso"), {}, 10, 10);
  for (const Vec& axis : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}}) {
    const Projected seen = camera.turn(axis);
    EXPECT_NEAR(std::hypot(seen.x, seen.y), std::sqrt(2.0 / 3), 1e-12);
  }
}

TEST(Camera, FitsAnyPointsTightlyAndKeepsDistances) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> degrees(-89, 89);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<Point> points = random_points(random, 20);
    const std::string name = std::to_string(2 * degrees(random)) + "," + std::to_string(degrees(random));
    const Camera camera(view_named(name), points, 400, 300);
    double x_min = 1e9, x_max = -1e9, y_min = 1e9, y_max = -1e9;
    std::vector<Projected> seen;
    for (const Point& p : points) {
      seen.push_back(camera.project(p));
      x_min = std::min(x_min, seen.back().x), x_max = std::max(x_max, seen.back().x);
      y_min = std::min(y_min, seen.back().y), y_max = std::max(y_max, seen.back().y);
    }
    EXPECT_NEAR((x_min + x_max) / 2, 200, 1e-9);
    EXPECT_NEAR((y_min + y_max) / 2, 150, 1e-9);
    EXPECT_NEAR(std::max((x_max - x_min) / 400, (y_max - y_min) / 300), 0.94, 1e-9);
    const auto distance = [&](std::size_t i) {
      return std::hypot(seen[i].x - seen[0].x, seen[i].y - seen[0].y, seen[i].depth - seen[0].depth) /
             norm(points[i] - points[0]);
    };
    for (std::size_t i = 2; i < points.size(); ++i) EXPECT_NEAR(distance(i) / distance(1), 1, 1e-9);
  }
}

TEST(Camera, ZoomEnlargesAboutTheMiddle) {
  std::mt19937 random(2);
  const std::vector<Point> points = random_points(random, 8);
  const Camera once(view_named("iso"), points, 400, 300), thrice(view_named("iso"), points, 400, 300, 3);
  for (const Point& p : points) {
    EXPECT_NEAR(thrice.project(p).x - 200, 3 * (once.project(p).x - 200), 1e-9);
    EXPECT_NEAR(thrice.project(p).y - 150, 3 * (once.project(p).y - 150), 1e-9);
  }
}

TEST(Camera, RefusesNamesAndViewsWithoutDirection) {
  for (const char* name : {"", "-", "w", "xy", "iso2", "10", "10,", "10,b", "nan,0", "1,2,3"})
    EXPECT_THROW(direction_named(name), std::invalid_argument) << name;
  EXPECT_THROW(Camera({{0, 0, 1}, {0, 0, 2}}, {}, 10, 10), std::invalid_argument);
}

TEST(Camera, OnePointIsInTheMiddle) {
  const std::vector<Point> points = {{3, 4, 5}};
  const Projected seen = Camera(view_named("iso"), points, 40, 30).project(points[0]);
  EXPECT_NEAR(seen.x, 20, 1e-12);
  EXPECT_NEAR(seen.y, 15, 1e-12);
}

}  // namespace
}  // namespace weft::picture::camera_test

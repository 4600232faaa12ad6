// Tests of sizes from the boundary's curvature and of first layers at walls.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "meshing/base/error.h"
#include "meshing/geometry/model/analytic_model.h"
#include "meshing/metric/sources/curvature_metric.h"
#include "meshing/metric/sources/wall_metric.h"
#include "tests/support/meshes.h"

namespace weft::meshing::boundary_metric_test {
namespace {

using support::unit_cube;

double size_along(const LogMetric& l, const Vec& unit) {
  return 1 / std::sqrt(squared_length(exp_exact(l), unit));
}

TEST(CurvatureMetric, SizesASphereByItsRadius) {
  const MeshData mesh = support::ball(3, 2);
  const auto by_turn = curvature_metric(mesh, {20, 0, 45}),
             by_sagitta = curvature_metric(mesh, {0, 1e-3, 45});
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const bool surface = norm(mesh.points[v]) > 0.99;
    for (const Vec& axis : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}}) {
      EXPECT_NEAR(size_along(by_turn[v], axis) / (surface ? std::numbers::pi / 10 : largest_size(mesh)), 1,
                  0.01);
      EXPECT_NEAR(size_along(by_sagitta[v], axis) / (surface ? std::sqrt(8e-3) : largest_size(mesh)), 1,
                  0.01);
    }
  }
}

TEST(CurvatureMetric, SizesACylinderRoundItOnly) {
  const MeshData mesh = support::cylinder(24, 3, 6, 2);
  const double h = 2 * std::numbers::pi / 30;
  const auto field = curvature_metric(mesh, {30, 0, 45});
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Point& p = mesh.points[v];
    const double r = std::hypot(p.x, p.y);
    if (r < 0.99) {
      EXPECT_NEAR(size_along(field[v], {1, 0, 0}), largest_size(mesh), 1e-9);
      continue;
    }
    const Vec round = {-p.y, p.x, 0}, across = {p.x, p.y, 0};
    EXPECT_NEAR(size_along(field[v], round) / h, 1, 0.05);
    EXPECT_NEAR(size_along(field[v], across) / h, 1, 0.05);
    EXPECT_GT(size_along(field[v], {0, 0, 1}), 3 * h);
  }
}

/// A cone of radius 1 and height 1: rings of 12 at these heights, the tip, the centre of the base.
MeshData cone(const std::vector<double>& heights) {
  constexpr std::uint32_t kRing = 12;
  MeshData m;
  for (const double z : heights)
    for (std::uint32_t k = 0; k < kRing; ++k) {
      const double angle = 2 * std::numbers::pi * k / kRing;
      m.points.push_back({(1 - z) * std::cos(angle), (1 - z) * std::sin(angle), z});
    }
  const auto tip = static_cast<std::uint32_t>(m.points.size());
  m.points.push_back({0, 0, 1});
  m.points.push_back({0, 0, 0});
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::int32_t ref) {
    m.triangles.push_back({a, b, c});
    m.triangle_refs.push_back(ref);
  };
  for (std::uint32_t k = 0; k < kRing; ++k) {
    const std::uint32_t n = (k + 1) % kRing;
    add(n, k, tip + 1, 2);
    for (std::uint32_t r = 0; r + 1 < heights.size(); ++r) {
      add(kRing * r + k, kRing * r + n, kRing * (r + 1) + n, 1);
      add(kRing * r + k, kRing * (r + 1) + n, kRing * (r + 1) + k, 1);
    }
    add(tip - kRing + k, tip - kRing + n, tip, 1);
  }
  m.point_refs.assign(m.points.size(), 0);
  return m;
}

TEST(CurvatureMetric, AsksAtATipForNoMoreThanAThousandthOfTheFace) {
  const auto model = std::make_shared<const Model>(frustum_model({}, 1, 0, 1));
  for (const double last : {0.9, 0.99, 0.9999, 1 - 1e-6}) {
    const MeshData mesh = cone({0, 0.5, last});
    const auto field = curvature_metric(mesh, {20, 0, 45}, model);
    double least = largest_size(mesh);
    for (const LogMetric& l : field)
      for (const Vec& axis : {Vec{1, 0, 0}, Vec{0, 1, 0}}) {
        ASSERT_TRUE(std::isfinite(size_along(l, axis)));
        least = std::min(least, size_along(l, axis));
      }
    // Across the axis a cone of 45 degrees has the curvature cos 45 / r.
    const double radius = std::max((1 - last) * std::numbers::sqrt2, 1e-3 * norm(Vec{2, 2, 1}));
    EXPECT_NEAR(least / (2 * std::numbers::pi / 20 * radius), 1, 0.2) << last;
    const Vec x{1, 0, 0};
    EXPECT_NEAR(size_along(field[field.size() - 2], x), largest_size(mesh), 1e-9) << "the tip itself";
  }
}

TEST(CurvatureMetric, AsksNothingOfPlanes) {
  const MeshData mesh = unit_cube(4);
  for (const LogMetric& l : curvature_metric(mesh, {50, 1e-6, 45}))
    EXPECT_NEAR(size_along(l, {0, 0, 1}), std::sqrt(3.0), 1e-12);
}

TEST(WallMetric, GrowsFromTheWall) {
  const MeshData mesh = unit_cube(6);
  const auto field = wall_metric(mesh, {{5}, 0.01, 1.25, 0.1});
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const double across = 0.01 + 0.25 * mesh.points[v].z;
    EXPECT_NEAR(size_along(field[v], {0, 0, 1}), across, 1e-9);
    EXPECT_NEAR(size_along(field[v], {0.6, 0.8, 0}), std::max(across, 0.1), 1e-9);
  }
}

TEST(WallMetric, IntersectsTheDemandsOfWallsThatMeet) {
  const MeshData mesh = unit_cube(4);
  const auto field = wall_metric(mesh, {{1, 5}, 1e-3, 1.2, 0});
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Point& p = mesh.points[v];
    if (p.x == 0) {
      EXPECT_NEAR(size_along(field[v], {1, 0, 0}), 1e-3, 1e-9);
    }
    if (p.z == 0) {
      EXPECT_NEAR(size_along(field[v], {0, 0, 1}), 1e-3, 1e-9);
    }
    if (p.x == 0 && p.z == 0) {
      EXPECT_NEAR(size_along(field[v], {0, 1, 0}), std::sqrt(3.0), 1e-9);
    }
  }
}

TEST(WallMetric, PointsAwayFromACurvedWall) {
  const MeshData mesh = support::ball(3, 4);
  const auto field = wall_metric(mesh, {{1}, 0.01, 1.1, 0.5});
  for (std::size_t v = 1; v < mesh.points.size(); ++v) {
    const double r = norm(mesh.points[v]);
    EXPECT_NEAR(size_along(field[v], (1 / r) * mesh.points[v]), 0.01 + 0.1 * (1 - r), 0.002);
  }
}

TEST(WallMetric, RefusesWhatMakesNoSense) {
  const MeshData mesh = unit_cube(2);
  const auto error_of = [&](const WallOptions& options) -> std::string {
    try {
      wall_metric(mesh, options);
      return "no error";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(error_of({{1, 77}, 0.1, 1.2, 0}), "wall 77: no triangle has this reference");
  EXPECT_EQ(error_of({{1}, 0, 1.2, 0}), "wall: the height of the first layer is not positive");
  EXPECT_EQ(error_of({{1}, 0.1, 0.9, 0}), "wall: the growth of the layers is below 1");
}

TEST(BoundaryMetrics, DoNotDependOnTheThreads) {
  const MeshData mesh = support::cylinder(48, 4, 12, 2);
  const auto curvature = curvature_metric(mesh, {30, 1e-3, 45});
  const auto wall = wall_metric(mesh, {{1, 2}, 1e-3, 1.2, 0.1});
  for (const int threads : {1, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(curvature_metric(mesh, {30, 1e-3, 45}), curvature);
    EXPECT_EQ(wall_metric(mesh, {{1, 2}, 1e-3, 1.2, 0.1}), wall);
  }
}

}  // namespace
}  // namespace weft::meshing::boundary_metric_test

// The metric where a curved boundary bears shorter edges only.
#include "meshing/metric/surface_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshing/metric/sources/curvature_metric.h"
#include "tests/support/meshes.h"

namespace weft::meshing::surface_limit_test {
namespace {

constexpr double kHausd = 0.01;  // an edge of kAllowed has its middle half as far from the unit sphere
constexpr double kAllowed = 0.2;

LogMetricField uniform(const MeshData& mesh, double size) {
  return LogMetricField(mesh.points.size(), identity_tensor(-2 * std::log(size)));
}

LogMetricField demand_of(const MeshData& mesh) { return curvature_metric(mesh, {0, kHausd / 2, 45}); }

std::optional<LimitOfSurface> limit_at(const MeshData& mesh, double size) {
  return limit_of_surface(WholeDomain(mesh), demand_of(mesh), uniform(mesh, size));
}

double size_of(const LogMetric& l) { return std::exp(-trace(l) / 6); }

TEST(LimitOfSurface, IsNoneWhereTheMetricIsFineEnough) {
  const MeshData mesh = support::ball(3, 4);
  EXPECT_FALSE(limit_at(mesh, 0.5 * kAllowed));
  EXPECT_FALSE(limit_at(mesh, 1.2 * kAllowed));
  EXPECT_TRUE(limit_at(mesh, 1.3 * kAllowed));
}

TEST(LimitOfSurface, IsTheDemandAtTheBoundaryAndGrowsInwards) {
  const MeshData mesh = support::ball(3, 4);
  const auto limit = limit_at(mesh, 0.4);
  ASSERT_TRUE(limit);
  std::size_t on_boundary = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const double depth = 1 - norm(mesh.points[v]);
    on_boundary += depth < 1e-9;
    const double size = size_of(limit->demand[v]);
    if (depth < 1e-9) {
      EXPECT_NEAR(size / kAllowed, 1, 0.03);
    } else {
      EXPECT_GT(size, kAllowed * (1 + 0.2 * depth / kAllowed));
    }
  }
  EXPECT_EQ(limit->account.vertices, on_boundary);
  EXPECT_NEAR(limit->account.longest, 0.4 / kAllowed, 0.05);
  EXPECT_NEAR(norm(limit->account.where), 1, 1e-9);
}

TEST(LimitOfSurface, HasAShareOfTheComplexityAtMost) {
  const MeshData mesh = support::ball(3, 4);
  const WholeDomain domain(mesh);
  const auto limit = limit_of_surface(domain, demand_of(mesh), uniform(mesh, 1.5), 0.5);
  ASSERT_TRUE(limit);
  EXPECT_NEAR(domain.complexity(limit->demand) / domain.complexity(uniform(mesh, 1.5)), 0.5, 1e-9);
}

TEST(LimitOfSurface, StaysAwayFromWhereTheMetricIsFine) {
  const MeshData mesh = support::ball(3, 4);
  LogMetricField field = uniform(mesh, 0.4);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.points[v].x < 0) field[v] = identity_tensor(-2 * std::log(0.1));
  const auto limit = limit_of_surface(WholeDomain(mesh), demand_of(mesh), field);
  ASSERT_TRUE(limit);
  EXPECT_GE(limit->account.where.x, 0);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.points[v].x < -0.9) {
      EXPECT_GT(size_of(limit->demand[v]), 0.3);
    }
}

}  // namespace
}  // namespace weft::meshing::surface_limit_test

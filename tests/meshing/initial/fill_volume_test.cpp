// Volumes filled from their surface: sizes, quality, and a surface that stays.
#include "meshing/initial/fill_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "meshing/initial/point_distribution.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/metric/measures.h"
#include "tests/meshing/initial/initial_support.h"

namespace weft::meshing::fill_volume_test {
namespace {

using support::ball;
using support::box_surface;
using support::together;

MeshData grid_of(const MeshData& surface) { return make_initial_grid(close_surface(surface, {}), {}).mesh; }

Measures shapes(const MeshData& mesh) { return measure(mesh, LogMetricField(mesh.points.size())); }

TEST(FillVolume, KeepsTheSurfaceAndMakesGoodTets) {
  const MeshData grid = grid_of(ball(0.2));
  const MeshData mesh = fill_volume(grid, {}).mesh;
  EXPECT_TRUE(check_mesh(mesh).ok());
  EXPECT_EQ(mesh.triangles.size(), grid.triangles.size());
  EXPECT_EQ(check_mesh(mesh).area_by_ref, check_mesh(grid).area_by_ref);
  EXPECT_GT(shapes(mesh).quality_q01, 0.6);
  EXPECT_GT(shapes(mesh).quality_min, 0.3);
}

TEST(FillVolume, OpensTetsThatFacetsHoldFlat) {
  const MeshData grid = grid_of(together(box_surface({-2, -2, -2}, {2, 2, 2}, 6), ball(0.2)));
  EXPECT_GT(shapes(fill_volume(grid, {}).mesh).quality_min, 0.1);
}

/// Tets whose middle lies at x > 0.
std::size_t count_right(const MeshData& mesh) {
  return static_cast<std::size_t>(std::count_if(mesh.tets.begin(), mesh.tets.end(), [&](const auto& t) {
    return mesh.points[t[0]].x + mesh.points[t[1]].x + mesh.points[t[2]].x + mesh.points[t[3]].x > 0;
  }));
}

TEST(FillVolume, SizesDoNotCrossAThinGap) {
  const MeshData fine = box_surface({-1.005, 0, 0}, {-0.005, 1, 1}, 16);
  const MeshData coarse = box_surface({0, 0, 0}, {1, 1, 1}, 3);
  const MeshData beside = fill_volume(grid_of(together(fine, coarse)), {}).mesh;
  EXPECT_TRUE(check_mesh(beside).ok());
  EXPECT_LE(count_right(beside), fill_volume(grid_of(coarse), {}).mesh.tets.size() * 3 / 2);
}

TEST(FillVolume, GrowsFromTheSurfaceUpToTheLargestSize) {
  const MeshData grid = grid_of(box_surface({}, {1, 1, 1}, 10));
  FillOptions fine, coarse;
  fine.growth = 1.05;
  coarse.growth = 1.8;
  const std::size_t few = fill_volume(grid, coarse).mesh.tets.size();
  EXPECT_GT(fill_volume(grid, fine).mesh.tets.size(), few * 3 / 2);
  coarse.size = 0.1;
  EXPECT_GT(fill_volume(grid, coarse).mesh.tets.size(), few * 3 / 2);
}

TEST(FillVolume, RemeshesTheSurfaceWhenAsked) {
  const MeshData grid = grid_of(box_surface({}, {1, 1, 1}, 1));
  FillOptions options;
  options.size = 0.2;
  options.remesh_surface = true;
  const MeshData mesh = fill_volume(grid, options).mesh;
  EXPECT_TRUE(check_mesh(mesh).ok());
  EXPECT_NEAR(check_mesh(mesh).volume, 1, 1e-9);
  EXPECT_GT(mesh.triangles.size(), 100u);
}

/// A cube with a patch of tiny squares in the middle of each face, joined to its corners by needles.
MeshData cube_with_fine_patches(double half, double cell, std::uint32_t n) {
  MeshData m;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-half, half}) {
      const auto first = static_cast<std::uint32_t>(m.points.size());
      const auto add = [&](double a, double b) {
        Point p;
        p[axis] = side, p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
        m.points.push_back(p);
      };
      const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (side < 0) std::swap(b, c);
        m.triangles.push_back({first + a, first + b, first + c});
        m.triangle_refs.push_back(2 * axis + (side > 0) + 1);
      };
      const auto at = [&](std::uint32_t i, std::uint32_t j) { return i + j * (n + 1); };
      for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i) add(cell * (i - 0.5 * n), cell * (j - 0.5 * n));
      for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
          triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
          triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
      const std::uint32_t corner = at(0, n + 1);
      for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) add(a * half, b * half);
      for (std::uint32_t i = 0; i < n; ++i) {
        triangle(corner, at(i + 1, 0), at(i, 0));
        triangle(corner + 1, at(n, i + 1), at(n, i));
        triangle(corner + 2, at(n - i - 1, n), at(n - i, n));
        triangle(corner + 3, at(0, n - i - 1), at(0, n - i));
      }
      triangle(corner, corner + 1, at(n, 0));
      triangle(corner + 1, corner + 2, at(n, n));
      triangle(corner + 2, corner + 3, at(0, n));
      triangle(corner + 3, corner, at(0, 0));
    }
  m.point_refs.assign(m.points.size(), 0);
  return m;
}

TEST(FillVolume, LongEdgesBetweenFinePartsOfTheSurfaceAreNotFilledWithPoints) {
  std::uint64_t first = 0, most = 0;  // tets while it is adapted; in the end there are a few dozen or hundred
  FillOptions options;
  options.growth = 2;
  options.remesh_surface = true;
  options.adapt.progress = [&](const std::string&, double, std::uint64_t tets) {
    if (first == 0) first = tets;
    most = std::max(most, tets);
  };
  const MeshData mesh = fill_volume(grid_of(cube_with_fine_patches(100, 0.01, 6)), options).mesh;
  EXPECT_TRUE(check_mesh(mesh).ok());
  EXPECT_NEAR(check_mesh(mesh).volume, 8e6, 1e-3);
  EXPECT_GT(first, 0u);
  EXPECT_LE(most, first + first / 4);
}

TEST(FillVolume, TakesSizesFromABackground) {
  const MeshData grid = grid_of(box_surface({}, {1, 1, 1}, 5));
  const LogMetricField sizes(grid.points.size(), identity_tensor(-2 * std::log(0.1)));
  FillOptions options;
  options.background = {&grid, &sizes};
  EXPECT_GT(fill_volume(grid, options).mesh.tets.size(), 2000u);
}

TEST(FillVolume, KeepsListedEdgesAndCorners) {
  MeshData surface = box_surface({}, {1, 1, 1}, 2);
  surface.edges = {{0, 1}};
  surface.edge_refs = {7};
  surface.ridges = {0};
  surface.corners = {0};
  const MeshData mesh = fill_volume(grid_of(surface), {}).mesh;
  ASSERT_EQ(mesh.edges.size(), 1u);
  EXPECT_EQ(mesh.edge_refs[0], 7);
  EXPECT_EQ(mesh.points[mesh.edges[0][0]], surface.points[0]);
  EXPECT_EQ(mesh.points[mesh.corners.at(0)], surface.points[0]);
  EXPECT_TRUE(mesh.required_triangles.empty());
}

TEST(FillVolume, KeepsWhatIsRequired) {
  MeshData surface = box_surface({}, {1, 1, 1}, 2);
  surface.edges = {{0, 1}, {1, 2}};
  surface.edge_refs = {7, 8};
  surface.required_edges = {0};
  surface.required_points = {4};
  surface.required_triangles = {2};
  for (const bool remesh : {false, true}) {
    FillOptions options;
    options.remesh_surface = remesh;
    options.size = 0.1;
    const MeshData mesh = fill_volume(grid_of(surface), options).mesh;
    std::size_t points = 0, edges = 0, triangles = 0;
    for (const std::uint32_t v : mesh.required_points) points += mesh.points[v] == surface.points[4];
    for (const std::uint32_t e : mesh.required_edges) edges += mesh.edge_refs[e] == 7;
    const auto middle = [](const MeshData& m, std::uint32_t t) {
      return m.points[m.triangles[t][0]] + m.points[m.triangles[t][1]] + m.points[m.triangles[t][2]];
    };
    for (const std::uint32_t t : mesh.required_triangles)
      triangles += norm(middle(mesh, t) - middle(surface, 2)) < 1e-12;
    EXPECT_EQ(points, 1u) << remesh;
    EXPECT_EQ(edges, 1u) << remesh;
    EXPECT_EQ(triangles, 1u) << remesh;
    EXPECT_TRUE(remesh || mesh.required_triangles.size() == 1) << mesh.required_triangles.size();
  }
}

TEST(PointDistribution, AKeptSurfaceHasItsOwnSizesWhereTheyGrowNotTooFast) {
  const MeshData grid =
      grid_of(together(box_surface({}, {1, 1, 1}, 4), box_surface({1.5, 0, 0}, {1.6, 0.1, 0.1}, 4)));
  const PointDistribution sizes(grid, 1.01, 0);
  const std::vector<SpreadSize> inside = spread_sizes(grid, sizes.size_sources());
  const LogMetricField everywhere = sizes.sample(grid.points, 1);
  const auto size = [](const LogMetric& m) { return std::exp(-trace(m) / 6); };
  for (std::size_t v = 0; v < grid.points.size(); ++v) {
    EXPECT_GE(inside[v].size, size(everywhere[v]) * (1 - 1e-12));
    EXPECT_GT(inside[v].size, grid.points[v].x <= 1 ? 0.25 : 0.025);
  }
  EXPECT_LT(size(everywhere[0]), 0.05);  // what the small box would have made of the large one
}

TEST(PointDistribution, IsTheLeastOverAllSurfaceVertices) {
  const MeshData surface = together(ball(0.3), box_surface({3, 3, 3}, {4, 4, 4}, 2));
  const PointDistribution one(surface, 1.3, 0), limited(surface, 1.3, 0.4), constant(surface, 1, 0);
  const Point far = {-10, 0, 0};
  const double at_ball = one({-1, 0, 0});
  EXPECT_NEAR(one(far), at_ball + 0.3 * 9, 0.1);
  EXPECT_EQ(limited(far), 0.4);
  EXPECT_LE(constant(far), at_ball);
}

}  // namespace
}  // namespace weft::meshing::fill_volume_test

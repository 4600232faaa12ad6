// Initial grids have the surface's triangles, conform, and fill the right volumes.
#include "meshing/initial/initial_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>
#include <set>

#include "meshing/base/error.h"
#include "meshing/initial/recovery/recover_edges.h"
#include "meshing/initial/recovery/recovery.h"
#include "meshing/initial/shapes.h"
#include "meshing/io/mesh_file.h"
#include "meshing/mesh/check_mesh.h"
#include "tests/meshing/initial/initial_support.h"
#include "tests/support/case_files.h"

namespace weft::meshing::initial_grid_test {
namespace {

using support::ball;
using support::box_surface;
using support::enclosed_volume;
using support::together;

/// Grids it and checks all that holds for every surface; returns the grid.
InitialGrid grid_of(const MeshData& surface, bool keep_enclosed = false) {
  const ClosedSurface closed = close_surface(surface, {});
  InitialGrid grid = make_initial_grid(closed, {keep_enclosed});
  const CheckReport report = check_mesh(grid.mesh);
  EXPECT_TRUE(report.ok()) << report.problems.front();
  EXPECT_EQ(grid.left_on_surface, 0u);
  EXPECT_EQ(grid.mesh.triangles.size(), closed.mesh.triangles.size());
  const auto key = [](std::array<std::uint32_t, 3> t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  std::set<std::array<std::uint32_t, 3>> wanted, found;
  for (const auto& t : closed.mesh.triangles) wanted.insert(key(t));
  for (const auto& t : grid.mesh.triangles) found.insert(key(t));
  EXPECT_EQ(found, wanted);
  return grid;
}

double volume(const InitialGrid& grid) { return check_mesh(grid.mesh).volume; }

TEST(InitialGrid, OfABoxOfTwelveTriangles) {
  EXPECT_NEAR(volume(grid_of(box_surface({}, {1, 2, 3}, 1))), 6, 1e-12);
}

TEST(InitialGrid, OfADividedBox) { EXPECT_NEAR(volume(grid_of(box_surface({}, {1, 1, 1}, 7))), 1, 1e-12); }

TEST(InitialGrid, OfAFlatBoxWithNeedles) {
  EXPECT_NEAR(volume(grid_of(box_surface({}, {1, 1, 1e-4}, 5))), 1e-4, 1e-15);
}

/// Two cubes side by side and a cylinder that stands on both. Steiner points leave its arcs, and what the
/// sides of such a point take away meets at facets farther off (once they were lost, and the bodies one).
TEST(InitialGrid, OfBodiesThatTouchHasAllTheirFacets) {
  const InitialGrid grid = grid_of(read_mesh(std::string(WEFT_TEST_DATA) + "/touching-bodies.mesh"), true);
  EXPECT_EQ(grid.regions, 3u);
  EXPECT_NEAR(volume(grid), 2.28235897396, 1e-9);
}

TEST(InitialGrid, OfBodies) {
  for (const MeshData& surface : {ball(0.3), cylinder_surface({{}, 1, 2, 0.3}), delta_wing_surface()})
    EXPECT_NEAR(volume(grid_of(surface)), std::abs(enclosed_volume(surface)),
                1e-9 * std::abs(enclosed_volume(surface)));
}

TEST(InitialGrid, OfBumpySurfaces) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> at(0.5, 1.5);
    MeshData surface = ball(0.25);
    for (Point& p : surface.points) p = at(random) * p;
    EXPECT_NEAR(volume(grid_of(surface)), enclosed_volume(surface), 1e-9) << seed;
  }
}

TEST(InitialGrid, OfPrismsWithEndsOfNeedles) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const int teeth = 3 + static_cast<int>(random() % 30);
    const MeshData surface = support::prism(support::gear_outline(teeth), random);
    EXPECT_NEAR(volume(grid_of(surface)), enclosed_volume(surface), 1e-9) << seed;
  }
}

TEST(InitialGrid, OfTurnedPrismsWhoseEndsArePlanarUpToRounding) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    const int teeth = 3 + static_cast<int>(random() % 12);
    const MeshData surface = support::turned(support::prism(support::gear_outline(teeth), random), random);
    EXPECT_NEAR(volume(grid_of(surface)), enclosed_volume(surface), 1e-9) << seed;
  }
}

TEST(InitialGrid, OfBoxesInRandomNeedles) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    MeshData surface = support::prism(support::square_outline(2 + random() % 10, random), random);
    if (seed % 2 == 0) surface = support::turned(surface, random);
    EXPECT_NEAR(volume(grid_of(surface)), enclosed_volume(surface), 1e-9) << seed;
  }
}

TEST(InitialGridCases, OfTheDeltaWingsSurfaceWithItsBoundaryLayers) {
  const auto start = support::case_files() / "delta-wing" / "start.meshb";
  if (!std::filesystem::exists(start)) GTEST_SKIP() << "NOT TESTED: no " << start << " (set WEFT_CASES)";
  const MeshData surface = read_mesh(start.string());
  EXPECT_NEAR(volume(grid_of(surface)), std::abs(enclosed_volume(surface)), 1e-6);
}

TEST(InitialGrid, OfTheDeltaWingWithSizes) {
  for (const double size : {0.3, 0.1}) {
    const MeshData surface = delta_wing_surface({size});
    for (std::size_t i = 0; i < surface.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3 && surface.triangle_refs[i] <= 4; ++k)
        EXPECT_LE(
            norm(surface.points[surface.triangles[i][k]] - surface.points[surface.triangles[i][(k + 1) % 3]]),
            size);
    EXPECT_NEAR(volume(grid_of(surface)), enclosed_volume(delta_wing_surface()), 1e-9);
  }
}

TEST(InitialGrid, TakesAShellInsideForAHoleOrAMaterial) {
  const MeshData surface = together(box_surface({-2, -2, -2}, {2, 2, 2}, 3), ball(0.4));
  EXPECT_NEAR(volume(grid_of(surface)), 64 - enclosed_volume(ball(0.4)), 1e-9);
  const InitialGrid both = grid_of(surface, true);
  EXPECT_EQ(both.regions, 2u);
  EXPECT_NEAR(check_mesh(both.mesh).volume_by_ref.at(2), enclosed_volume(ball(0.4)), 1e-9);
}

TEST(InitialGrid, FillsABodyInAHole) {
  const MeshData surface = together(ball(0.5, {}, 3), together(ball(0.4, {}, 2), ball(0.3)));
  const double expected =
      enclosed_volume(ball(0.5, {}, 3)) - enclosed_volume(ball(0.4, {}, 2)) + enclosed_volume(ball(0.3));
  EXPECT_NEAR(volume(grid_of(surface)), expected, 1e-9);
}

/// A tetrahedron, its apex first.
MeshData tetrahedron(const Point& a, const Point& b, const Point& c, const Point& d) {
  MeshData m;
  m.points = {a, b, c, d};
  m.point_refs.assign(4, 0);
  m.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  m.triangle_refs.assign(4, 9);
  return m;
}

TEST(InitialGrid, LeavesAVoidThatTouchesTheOutsideAtAVertex) {
  const MeshData hollow = together(box_surface({}, {1, 1, 1}, 1),
                                   tetrahedron({0, 0, 0}, {0.6, 0.2, 0.2}, {0.2, 0.6, 0.2}, {0.2, 0.2, 0.6}));
  const InitialGrid grid = grid_of(hollow);
  EXPECT_EQ(grid.regions, 1u);
  EXPECT_EQ(grid.voids, 1u);
  EXPECT_NEAR(volume(grid), 1 - 0.16 / 6, 1e-12);
}

TEST(InitialGrid, FillsABodyThatTouchesItsHoleAtAVertex) {
  const MeshData body = tetrahedron({1, 0, 0}, {0, 0.5, 0}, {0, -0.5, 0.5}, {0, -0.5, -0.5});
  const MeshData surface = together(box_surface({-2, -2, -2}, {2, 2, 2}, 2),
                                    together(box_surface({-1, -1, -1}, {1, 1, 1}, 2), body));
  const InitialGrid grid = grid_of(surface);
  EXPECT_EQ(grid.regions, 2u);
  EXPECT_NEAR(volume(grid), 64 - 8 + 1.0 / 6, 1e-12);
}

std::uint32_t point_at(const MeshData& m, const Point& p) {
  return static_cast<std::uint32_t>(std::find(m.points.begin(), m.points.end(), p) - m.points.begin());
}

TEST(InitialGrid, HasNothingThatLiesBetweenTwoVoids) {
  const MeshData voids =
      together(box_surface({-1, -1, -1}, {0, 1, 1}, 2), box_surface({0, -1, -1}, {1, 1, 1}, 2));
  MeshData surface = together(box_surface({-2, -2, -2}, {3, 2, 2}, 3), voids);
  const std::uint32_t middle = point_at(surface, {0, 0, 0}), rim = point_at(surface, {0, 0, 1}),
                      next = point_at(surface, {0, 1, 1});
  surface.edges = {{middle, rim}, {rim, next}};
  surface.edge_refs = {5, 6};
  surface.ridges = {0, 1};
  surface.corners = {middle, rim};
  const ClosedSurface closed = close_surface(surface, {});
  ASSERT_EQ(closed.mesh.edges.size(), 2u);
  const MeshData grid = make_initial_grid(closed, {}).mesh;
  const CheckReport report = check_mesh(grid);
  EXPECT_TRUE(report.ok()) << report.problems.front();
  EXPECT_EQ(report.unreferenced_points, 0u);
  EXPECT_NEAR(report.volume, 80 - 8, 1e-9);
  EXPECT_EQ(grid.edge_refs, std::vector<std::int32_t>{6});
  EXPECT_EQ(grid.ridges, std::vector<std::uint32_t>{0});
  ASSERT_EQ(grid.corners.size(), 1u);
  EXPECT_EQ(grid.points[grid.corners[0]], (Point{0, 0, 1}));
}

TEST(InitialGrid, DividesMaterialsAtACommonFace) {
  const InitialGrid grid =
      grid_of(together(box_surface({0, 0, 0}, {1, 1, 1}, 3), box_surface({1, 0, 0}, {2, 1, 1}, 3)));
  EXPECT_EQ(grid.regions, 2u);
  for (const auto& [ref, v] : check_mesh(grid.mesh).volume_by_ref) EXPECT_NEAR(v, 1, 1e-12) << ref;
}

TEST(InitialGrid, TurnsTrianglesOutwards) {
  MeshData surface = ball(0.4);
  std::mt19937 random(1);
  for (auto& t : surface.triangles)
    if (random() & 1u) std::swap(t[0], t[1]);
  const InitialGrid grid = grid_of(surface);
  EXPECT_NEAR(enclosed_volume(grid.mesh), volume(grid), 1e-9);
  EXPECT_GT(grid.turned, surface.triangles.size() / 4);
}

std::string refusal(const std::function<void()>& refuse) {
  try {
    refuse();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Recovery, RefusesByTheNumbersOfTheInput) {
  Recovery r;
  for (const Point& p : {Point{0, 0, 0}, {2, 0, 0}, {0, 4, 0}, {2, 4, 0}}) r.grid.add_point(p);
  r.facets = {{0, 1, 2}, {1, 3, 2}};
  const std::vector<std::uint32_t> source = {7, 9};
  r.source = source;
  list_input_edges(r);
  EXPECT_EQ(refusal([&] { r.refuse_facet(1); }), std::string("triangle 10: ") + Recovery::kTooThin);
  EXPECT_EQ(refusal([&] { r.refuse_edge(r.facet_edges[0][1], "is wrong"); }),
            "triangle 8: its edge near (1, 2, 0) is wrong");
  EXPECT_EQ(refusal([&] { r.refuse_edge(r.facet_edges[1][0], "is wrong"); }),
            "triangle 10: its edge near (2, 2, 0) is wrong");
}

TEST(InitialGrid, RepeatsItself) {
  const MeshData surface = box_surface({}, {1, 1, 1}, 4);
  EXPECT_EQ(grid_of(surface).mesh.tets, grid_of(surface).mesh.tets);
}

}  // namespace
}  // namespace weft::meshing::initial_grid_test

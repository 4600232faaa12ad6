// Tests of the full check: sound meshes pass, and every kind of damage is found and named.
#include "meshing/mesh/check_mesh.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "meshing/mesh/predicates.h"
#include "tests/support/meshes.h"

namespace weft::meshing::check_mesh_test {
namespace {

using support::mesh_of;
using support::two_tets;
using support::unit_cube;
using support::unit_cube_of_fives;

std::string all_of(const CheckReport& report) {
  return std::accumulate(report.problems.begin(), report.problems.end(), std::string(),
                         [](const std::string& a, const std::string& b) { return a + b + "\n"; });
}

::testing::AssertionResult finds(const MeshData& mesh, const std::string& problem) {
  const CheckReport report = check_mesh(mesh);
  for (const std::string& found : report.problems)
    if (found == problem) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "not found among: " << all_of(report);
}

::testing::AssertionResult finds_only(const MeshData& mesh, const std::string& problem) {
  const CheckReport report = check_mesh(mesh);
  if (report.num_problems == 1 && report.problems[0] == problem) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "found: " << all_of(report);
}

TEST(CheckMesh, PassesTwoTets) {
  const CheckReport report = check_mesh(two_tets());
  EXPECT_TRUE(report.ok()) << all_of(report);
  EXPECT_EQ(report.num_components, 1u);
  EXPECT_DOUBLE_EQ(report.volume, 1.0 / 3);
  EXPECT_EQ(report.unreferenced_points, 0u);
}

TEST(CheckMesh, PassesJitteredAndShuffledBoxes) {
  for (unsigned seed = 1; seed <= 5; ++seed)
    for (MeshData mesh : {unit_cube(5), unit_cube_of_fives(5)}) {
      support::jitter_interior(mesh, 0.1 / 5, seed);
      support::shuffle(mesh, seed);
      const CheckReport report = check_mesh(mesh);
      EXPECT_TRUE(report.ok()) << all_of(report);
      EXPECT_EQ(report.num_components, 1u);
      EXPECT_NEAR(report.volume, 1, 1e-14);
      double area = 0;
      for (const auto& [ref, part] : report.area_by_ref) area += part;
      EXPECT_NEAR(area, 6, 1e-13);
    }
}

TEST(CheckMesh, SumsVolumesAndAreasByReference) {
  MeshData mesh = unit_cube(4);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    const double x = mesh.points[a].x + mesh.points[b].x + mesh.points[c].x + mesh.points[d].x;
    mesh.tet_refs[t] = x < 4 * 0.25 ? 7 : 9;
  }
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  mesh.required_triangles.clear();
  support::add_boundary_triangles(mesh);
  const CheckReport report = check_mesh(mesh);
  EXPECT_TRUE(report.ok()) << all_of(report);
  EXPECT_NEAR(report.volume_by_ref.at(7), 0.25, 1e-14);
  EXPECT_NEAR(report.volume_by_ref.at(9), 0.75, 1e-14);
  EXPECT_NEAR(report.area_by_ref.at(1), 6, 1e-13);
  EXPECT_NEAR(report.area_by_ref.at(2), 1, 1e-14);
}

TEST(CheckMesh, CompensatesRoundingInLongSums) {
  MeshData mesh = unit_cube(40);  // 384,000 equal tets: plain summation is off by several 1e-13
  EXPECT_NEAR(check_mesh(mesh).volume, 1, 1e-15);
}

TEST(CheckMesh, SeparatesTheComponents) {
  MeshData mesh = two_tets();
  const std::uint32_t n = 5;
  for (std::uint32_t v = 0; v < n; ++v) mesh.points.push_back(mesh.points[v] + Point{5, 0, 0});
  mesh.points.push_back({9, 9, 9});
  mesh.point_refs.resize(mesh.points.size());
  for (std::size_t t = 0; t < 2; ++t) {
    const auto [a, b, c, d] = mesh.tets[t];
    mesh.tets.push_back({a + n, b + n, c + n, d + n});
  }
  mesh.tet_refs.assign(4, 1);
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  support::add_boundary_triangles(mesh);
  const CheckReport report = check_mesh(mesh);
  EXPECT_TRUE(report.ok()) << all_of(report);
  EXPECT_EQ(report.num_components, 2u);
  EXPECT_EQ(report.unreferenced_points, 1u);
}

TEST(CheckMesh, TetsThatTouchInAnEdgeOnlyAreTwoComponents) {
  const MeshData mesh = mesh_of({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                                {{0, 2, 3, 1}, {0, 4, 5, 1}});
  EXPECT_EQ(check_mesh(mesh).num_components, 2u);
}

TEST(CheckMesh, FindsAnInvertedTet) {
  MeshData mesh = two_tets();
  std::swap(mesh.tets[1][0], mesh.tets[1][1]);
  EXPECT_TRUE(finds_only(mesh, "tet 2: inverted (its orientation is negative)"));
}

TEST(CheckMesh, FindsAVertexMovedThroughTheOppositeFace) {
  MeshData mesh = two_tets();
  mesh.points[4] = {0.2, 0.2, 0.5};
  EXPECT_TRUE(finds(mesh, "tet 2: inverted (its orientation is negative)"));
  EXPECT_TRUE(finds(mesh, "face (1 2 3): tets 1 and 2 lie on the same side of it"));
}

TEST(CheckMesh, JudgesNearlyFlatTetsExactly) {
  // The last vertex is the exact sum of the second and third: the tet is flat, though not when computed in
  // doubles.
  const Point b{251610956, 205883657, 770031841}, c{504941597, 580866285, 898143645};
  EXPECT_GT(six_volume({}, b, c, b + c), 0);
  EXPECT_TRUE(
      finds_only(mesh_of({{}, b, c, b + c}, {{0, 1, 2, 3}}), "tet 1: flat (its orientation is zero)"));
  // Off that plane by one unit: positive, though zero when computed in doubles.
  const Point e{484999652, 852346877, 661874386}, f{767636108, 216507193, 168124752};
  const Point g = e + f + Point{1, 0, 0};
  EXPECT_EQ(six_volume({}, e, f, g), 0);
  EXPECT_TRUE(check_mesh(mesh_of({{}, e, f, g}, {{0, 1, 2, 3}})).ok());
}

TEST(CheckMesh, FindsADuplicateTet) {
  MeshData mesh = two_tets();
  mesh.tets.push_back({1, 2, 0, 3});
  mesh.tet_refs.push_back(1);
  EXPECT_TRUE(finds(mesh, "tets 1 and 3: have the same vertices"));
  EXPECT_TRUE(finds(mesh, "face (1 2 3): shared by 3 tets: 1 2 3"));
}

TEST(CheckMesh, FindsAFaceOfThreeTets) {
  MeshData mesh = two_tets();
  mesh.points.push_back({0.3, 0.3, 2});
  mesh.point_refs.push_back(0);
  mesh.tets.push_back({0, 1, 2, 5});
  mesh.tet_refs.push_back(1);
  EXPECT_TRUE(finds(mesh, "face (1 2 3): shared by 3 tets: 1 2 3"));
}

TEST(CheckMesh, FindsTwoTetsOnTheSameSideOfAFace) {
  MeshData mesh = two_tets();
  mesh.tets[1] = {0, 1, 2, 4};
  mesh.points[4] = {0.2, 0.2, 0.5};
  EXPECT_TRUE(finds_only(mesh, "face (1 2 3): tets 1 and 2 lie on the same side of it"));
}

TEST(CheckMesh, FindsAMissingTriangle) {
  MeshData mesh = two_tets();
  mesh.triangles.erase(mesh.triangles.begin());  // the map behind the fixture begins with face (1 2 4)
  mesh.triangle_refs.pop_back();
  EXPECT_TRUE(finds_only(mesh, "face (1 2 4) of tet 1: on the boundary without a triangle"));
}

TEST(CheckMesh, FindsAMissingTriangleBetweenReferences) {
  MeshData mesh = two_tets();
  mesh.tet_refs = {1, 2};
  EXPECT_TRUE(
      finds_only(mesh, "face (1 2 3): between tets 1 and 2 of different references without a triangle"));
}

TEST(CheckMesh, AllowsATriangleInsideOneReference) {
  MeshData mesh = two_tets();
  mesh.triangles.push_back({0, 1, 2});
  mesh.triangle_refs.push_back(5);
  EXPECT_TRUE(check_mesh(mesh).ok());
}

TEST(CheckMesh, FindsATriangleThatIsNoFace) {
  MeshData mesh = two_tets();
  mesh.triangles.push_back({0, 3, 4});
  mesh.triangle_refs.push_back(1);
  EXPECT_TRUE(finds_only(mesh, "triangle 7: is not a face of any tet"));
}

TEST(CheckMesh, FindsADuplicateTriangle) {
  MeshData mesh = two_tets();
  const auto [a, b, c] = mesh.triangles[2];
  mesh.triangles.push_back({b, c, a});
  mesh.triangle_refs.push_back(1);
  EXPECT_TRUE(finds_only(mesh, "triangles 3 and 7: have the same vertices"));
}

TEST(CheckMesh, FindsATJunction) {
  // Tet 2 of two_tets is split at the middle of edge (0 1), tet 1 is not; the triangles are those of the
  // whole.
  MeshData mesh = two_tets();
  mesh.points.push_back({0.5, 0, 0});
  mesh.point_refs.push_back(0);
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 5, 4}, {5, 2, 1, 4}};
  mesh.tet_refs.assign(3, 1);
  EXPECT_TRUE(finds(mesh, "face (1 2 3) of tet 1: on the boundary without a triangle"));
  EXPECT_TRUE(finds(mesh, "face (1 3 6) of tet 2: on the boundary without a triangle"));
  EXPECT_TRUE(finds(mesh, "face (2 3 6) of tet 3: on the boundary without a triangle"));
}

TEST(CheckMesh, FindsAHoleInABigMesh) {
  MeshData mesh = unit_cube(8);
  const auto hole = mesh.tets[1000];
  mesh.tets.erase(mesh.tets.begin() + 1000);
  mesh.tet_refs.pop_back();
  const CheckReport report = check_mesh(mesh);
  EXPECT_GE(report.num_problems, 1u);
  EXPECT_LE(report.num_problems, 4u);
  EXPECT_NEAR(report.volume, 1 - 1.0 / (6 * 512), 1e-14) << hole[0];
}

TEST(CheckMesh, FindsAnEdgeThatIsNone) {
  MeshData mesh = two_tets();
  mesh.edges = {{0, 1}, {3, 4}, {4, 0}};
  mesh.edge_refs = {0, 0, 0};
  EXPECT_TRUE(finds_only(mesh, "edge 2: is not an edge of any tet or triangle"));
}

TEST(CheckMesh, FindsVerticesOutOfRangeOrRepeated) {
  MeshData mesh = two_tets();
  mesh.tets[1][2] = 5;
  EXPECT_TRUE(finds_only(mesh, "tet 2: vertex 6 is out of range (5 points)"));
  mesh = two_tets();
  mesh.tets[0] = {0, 1, 0, 3};
  EXPECT_TRUE(finds_only(mesh, "tet 1: vertex 1 appears twice"));
  mesh = two_tets();
  mesh.triangles[4][0] = 0xFFFFFFFFu;
  EXPECT_TRUE(finds_only(mesh, "triangle 5: vertex 4294967296 is out of range (5 points)"));
  mesh = two_tets();
  mesh.edges = {{1, 1}};
  mesh.edge_refs = {0};
  EXPECT_TRUE(finds_only(mesh, "edge 1: vertex 2 appears twice"));
}

TEST(CheckMesh, FindsListEntriesOutOfRange) {
  MeshData mesh = two_tets();
  mesh.edges = {{0, 1}};
  mesh.edge_refs = {0};
  mesh.corners = {4, 5};
  mesh.required_points = {5};
  mesh.ridges = {0, 1};
  mesh.required_edges = {1};
  mesh.required_triangles = {5, 6};
  EXPECT_EQ(check_mesh(mesh).num_problems, 5u);
  EXPECT_TRUE(finds(mesh, "corner 2: index 6 is out of range (5 entities)"));
  EXPECT_TRUE(finds(mesh, "required triangle 2: index 7 is out of range (6 entities)"));
  mesh.association.edges = {{4, 1, 0, 1}, {5, 1, 0, 1}};
  EXPECT_TRUE(
      finds(mesh, "record 2 of a vertex on an edge of a model: vertex 6 is out of range (5 entities)"));
}

TEST(CheckMesh, FindsCoordinatesThatAreNotFinite) {
  MeshData mesh = two_tets();
  mesh.points[3].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(finds_only(mesh, "vertex 4: a coordinate is not finite"));
}

TEST(CheckMesh, FindsReferencesThatDoNotFitTheEntities) {
  MeshData mesh = two_tets();
  mesh.tet_refs.pop_back();
  EXPECT_TRUE(finds_only(mesh, "tet references: 1 given for 2 entities"));
}

TEST(CheckMesh, CountsWhereTheBodyTouchesItself) {
  const auto touching = [](const MeshData& mesh) {
    const CheckReport report = check_mesh(mesh);
    EXPECT_TRUE(report.ok());
    return std::pair(report.touching_edges, report.touching_vertices);
  };
  using Counts = std::pair<std::uint64_t, std::uint64_t>;
  EXPECT_EQ(touching(unit_cube(3)), Counts(0, 0));
  const MeshData at_edge = support::mesh_of(
      {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 2, 3, 1}, {0, 4, 5, 1}});
  EXPECT_EQ(touching(at_edge), Counts(1, 2));
  const MeshData at_vertex =
      support::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                       {{0, 1, 2, 3}, {0, 5, 4, 6}});
  EXPECT_EQ(touching(at_vertex), Counts(0, 1));
}

TEST(CheckMesh, CountsAllProblemsButNamesOnlySome) {
  MeshData mesh = unit_cube(4);
  for (auto& tet : mesh.tets) std::swap(tet[0], tet[1]);
  const CheckReport report = check_mesh(mesh, 3);
  EXPECT_EQ(report.num_problems, mesh.tets.size());
  EXPECT_EQ(report.problems.size(), 3u);
  EXPECT_EQ(report.problems[2], "tet 3: inverted (its orientation is negative)");
  EXPECT_TRUE(check_mesh(mesh, 0).problems.empty());
}

TEST(CheckMesh, SaysTheSameForAnyNumberOfThreads) {
  MeshData mesh = unit_cube(20);
  support::jitter_interior(mesh, 0.04);  // enough to invert some tets
  const CheckReport expected = check_mesh(mesh, 1000);
  EXPECT_FALSE(expected.ok());
  for (const int threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const CheckReport report = check_mesh(mesh, 1000);
    EXPECT_EQ(report.problems, expected.problems);
    EXPECT_EQ(report.volume, expected.volume);
    EXPECT_EQ(report.num_components, expected.num_components);
  }
}

TEST(Orientation, IsNoneWhereACoordinateIsNotFinite) {
  const Point o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  EXPECT_EQ(orientation(o, x, y, z), 1);
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    for (int i = 0; i < 3; ++i) {
      Point p = z;
      (i == 0 ? p.x : i == 1 ? p.y : p.z) = bad;
      EXPECT_EQ(orientation(o, x, y, p), 0);
      EXPECT_EQ(orientation(p, x, y, o), 0);
    }
}

TEST(Orientation, OfPointsSoNearThatProductsVanish) {
  const double s = std::ldexp(1.0, -359);
  const Point o{0, 0, 0}, u{s, 2 * s, -3 * s}, v{5 * s, -s, -4 * s}, w{2 * s, 2 * s, -4 * s};
  EXPECT_EQ(orientation(o, u, v, w), 0);
  EXPECT_EQ(orientation(o, u, v, {2 * s, 2 * s, 4 * s}), -orientation(o, v, u, {2 * s, 2 * s, 4 * s}));
  EXPECT_NE(orientation(o, u, v, {2 * s, 2 * s, 4 * s}), 0);
}

}  // namespace
}  // namespace weft::meshing::check_mesh_test

// What is mended and what is refused in a surface.
#include "meshing/initial/closed_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "meshing/base/error.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/repair_surface.h"
#include "meshing/initial/self_intersections.h"
#include "tests/meshing/initial/initial_support.h"

namespace weft::meshing::closed_surface_test {
namespace {

using support::ball;
using support::box_surface;
using support::together;
using testing::HasSubstr;

std::string refusal(const MeshData& surface) {
  try {
    close_surface(surface, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ClosedSurface, MergesPointsThatNearlyCoincide) {
  MeshData box = box_surface({0, 0, 0}, {1, 1, 1}, 2);
  for (std::size_t i = 0; i < box.points.size(); ++i) box.points[i].x += 1e-12 * double(i % 3);
  const ClosedSurface closed = close_surface(box, {});
  EXPECT_EQ(closed.mesh.points.size(), 26u);
  EXPECT_EQ(closed.mesh.triangles.size(), 48u);
  EXPECT_THAT(closed.warnings, testing::ElementsAre(HasSubstr("28 points merged")));
}

/// A box with a triangle without area on an edge that it lists: both sides know the edge, one its middle too.
MeshData box_with_a_degenerate_triangle() {
  MeshData box = box_surface({0, 0, 0}, {1, 1, 1}, 1);
  const auto [a, b, c] = box.triangles[0];  // its edge ab gets a vertex that only this side knows
  const auto v = static_cast<std::uint32_t>(box.points.size());
  box.points.push_back(midpoint(box.points[a], box.points[b]));
  box.point_refs.push_back(0);
  box.triangles[0] = {a, v, c};
  box.triangles.push_back({v, b, c});
  box.triangles.push_back({a, b, v});
  box.triangle_refs.insert(box.triangle_refs.end(), 2, 1);
  box.edges = {{b, c}, {a, b}};
  box.edge_refs = {4, 5};
  return box;
}

TEST(ClosedSurface, GivesDegenerateTrianglesToTheirNeighbours) {
  const ClosedSurface closed = close_surface(box_with_a_degenerate_triangle(), {});
  EXPECT_EQ(closed.mesh.triangles.size(), 14u);
  EXPECT_EQ(closed.mesh.points.size(), 9u);
}

TEST(ClosedSurface, ListsThePiecesOfAListedEdge) {
  MeshData box = box_with_a_degenerate_triangle();
  box.ridges = {1};
  box.required_edges = {1};
  const MeshData closed = close_surface(box, {}).mesh;
  ASSERT_THAT(closed.edge_refs, testing::ElementsAre(4, 5, 5));
  EXPECT_THAT(closed.ridges, testing::ElementsAre(1, 2));
  EXPECT_THAT(closed.required_edges, testing::ElementsAre(1, 2));
  const auto place = [&](std::size_t e, std::size_t end) { return closed.points[closed.edges[e][end]]; };
  EXPECT_EQ(place(1, 0), box.points[box.edges[1][0]]);
  EXPECT_EQ(place(1, 1), box.points.back());
  EXPECT_EQ(place(2, 0), box.points.back());
  EXPECT_EQ(place(2, 1), box.points[box.edges[1][1]]);
}

TEST(ClosedSurface, KeepsWhatIsRequired) {
  MeshData box = box_with_a_degenerate_triangle();
  const auto [a, b] = box.edges[1];
  std::uint32_t beyond = 1;  // the triangle that is split where the degenerate one gives way
  const auto has = [&](std::uint32_t t, const Point& p) {
    return std::ranges::any_of(box.triangles[t], [&](std::uint32_t v) { return box.points[v] == p; });
  };
  while (!has(beyond, box.points[a]) || !has(beyond, box.points[b])) ++beyond;
  box.required_triangles = {beyond};
  box.required_points = {b};
  const ClosedSurface closed = close_surface(box, {});
  ASSERT_EQ(closed.mesh.required_triangles.size(), 2u);
  for (const std::uint32_t t : closed.mesh.required_triangles) EXPECT_EQ(closed.source[t], beyond);
  ASSERT_EQ(closed.mesh.required_points.size(), 1u);
  EXPECT_EQ(closed.mesh.points[closed.mesh.required_points[0]], box.points[b]);
}

TEST(ClosedSurface, ATriangleThatIsRequiredOnceOfTwiceStaysSo) {
  MeshData two = together(box_surface({0, 0, 0}, {1, 1, 1}, 1), box_surface({1, 0, 0}, {2, 1, 1}, 1));
  const auto in_common = [&](std::uint32_t t) {
    return std::ranges::all_of(two.triangles[t], [&](std::uint32_t v) { return two.points[v].x == 1; });
  };
  auto last = static_cast<std::uint32_t>(two.triangles.size() - 1);
  while (!in_common(last)) --last;
  two.required_triangles = {last};
  EXPECT_EQ(close_surface(two, {}).mesh.required_triangles.size(), 1u);
}

TEST(ClosedSurface, GivesAFanOfDegenerateTrianglesToItsNeighbour) {
  // As tessellations of cones have them: a line to the tip, and triangles of its pieces with the tip.
  MeshData box = box_surface({0, 0, 0}, {1, 1, 1}, 1);
  const auto [a, b, c] = box.triangles[0];
  constexpr int kPieces = 30;
  std::uint32_t before = a;
  for (int i = 1; i < kPieces; ++i) {
    const auto v = static_cast<std::uint32_t>(box.points.size());
    box.points.push_back(box.points[a] + (double(i) / kPieces) * (box.points[b] - box.points[a]));
    box.point_refs.push_back(0);
    box.triangles.push_back({before, v, c});  // this side knows all pieces
    if (i > 1) box.triangles.push_back({v, before, a});
    before = v;
  }
  box.triangles[0] = {before, b, c};
  box.triangles.push_back({b, before, a});
  box.triangle_refs.assign(box.triangles.size(), 1);
  const ClosedSurface closed = close_surface(box, {});
  EXPECT_EQ(closed.mesh.points.size(), 8u + kPieces - 1);
  EXPECT_EQ(closed.mesh.triangles.size(), 12u + 2 * (kPieces - 1));
}

TEST(ClosedSurface, MergesTheCommonFaceOfTouchingSolids) {
  const MeshData pair = together(box_surface({0, 0, 0}, {1, 1, 1}, 2), box_surface({1, 0, 0}, {2, 1, 1}, 2));
  // The diagonals of the common squares agree because both faces are cut alike, seen from their own outside.
  const ClosedSurface closed = close_surface(pair, {});
  EXPECT_EQ(closed.mesh.triangles.size(), pair.triangles.size() - 8);
}

TEST(ClosedSurface, RefusesAnOpenOneNamingTriangleAndPlace) {
  MeshData box = box_surface({0, 0, 0}, {1, 1, 1}, 1);
  box.triangles.pop_back();
  box.triangle_refs.pop_back();
  EXPECT_THAT(refusal(box),
              testing::AllOf(HasSubstr("triangle "), HasSubstr("open"), HasSubstr("3 such edges")));
}

TEST(ClosedSurface, RefusesSelfIntersectionsNamingTriangles) {
  const MeshData crossing =
      together(box_surface({0, 0, 0}, {1, 1, 1}, 1), box_surface({0.5, 0.4, 0.3}, {2, 2, 2}, 1));
  EXPECT_THAT(refusal(crossing), testing::AllOf(HasSubstr("intersects itself"), HasSubstr("triangles ")));
  EXPECT_THAT(refusal({}), HasSubstr("none"));
}

TEST(ClosedSurface, RefusesOneTooLargeForItsDiagonal) {
  MeshData box = box_surface({0, 0, 0}, {1e160, 1e160, 1e160}, 1);
  EXPECT_THAT(refusal(box), HasSubstr("too large"));
  EXPECT_TRUE(repair_surface(box).empty());
  EXPECT_THAT(refusal(box), HasSubstr("too large"));
}

TEST(ClosedSurface, NamesTrianglesByTheNumbersGiven) {
  MeshData box = box_surface({0, 0, 0}, {1, 1, 1}, 1);
  box.required_triangles = {3};
  SurfaceChecks checks;
  for (std::uint32_t t = 0; t < box.triangles.size(); ++t) checks.source.push_back(100 + t);
  const ClosedSurface closed = close_surface(box, checks);
  EXPECT_EQ(closed.source, checks.source);
  EXPECT_THAT(closed.mesh.required_triangles, testing::ElementsAre(3));
  box.triangles.pop_back();
  box.triangle_refs.pop_back();
  checks.source.pop_back();
  try {
    close_surface(box, checks);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::ContainsRegex("^triangle 1[0-9][0-9]: "));
  }
}

TEST(SelfIntersections, SeesOverlapsOfEverySort) {
  const std::vector<Point> p = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0},   {0.5, 0.5, -1}, {0.5, 0.5, 1},
                                {3, 3, 1}, {1, 1, 0}, {0.5, 1, 0}, {-1, -1, 0},    {2, -2, 0}};
  const auto meet = [&](std::array<std::uint32_t, 3> a, std::array<std::uint32_t, 3> b) {
    return self_intersections(p, std::vector{a, b}, 9).size() == 1;
  };
  EXPECT_TRUE(meet({0, 1, 2}, {3, 4, 5}));   // nothing shared, pierced
  EXPECT_TRUE(meet({0, 1, 2}, {0, 6, 7}));   // a shared vertex, overlapping in a plane
  EXPECT_TRUE(meet({0, 1, 2}, {0, 1, 7}));   // a shared edge, folded upon itself
  EXPECT_FALSE(meet({0, 1, 2}, {0, 1, 9}));  // a shared edge, beside each other
  EXPECT_FALSE(meet({0, 1, 2}, {0, 8, 9}));  // a shared vertex
  EXPECT_FALSE(meet({0, 1, 2}, {0, 1, 4}));  // a shared edge, at an angle
}

TEST(SelfIntersections, GivesTheFirstPairsOfManyAndEndsWhereItIsInterrupted) {
  // A fan of triangles that all hold the same segment.
  constexpr std::uint32_t kCount = 1100;
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double x = std::cos(0.002 * i), y = std::sin(0.002 * i);
    points.insert(points.end(), {{-x, -y, -1}, {x, y, -1}, {0, 0, 1}});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto pairs = self_intersections(points, triangles, 2 * kCount);
  ASSERT_EQ(pairs.size(), 2 * kCount);
  for (std::uint32_t k = 0, s = 0, t = 1; k < pairs.size(); ++k) {
    EXPECT_EQ(pairs[k], (std::array{s, t}));
    if (++t == kCount) ++s, t = s + 1;
  }
  for (std::uint32_t i = 0; i + 3 < kCount; ++i)
    for (std::uint32_t k = 3 * i; k < 3 * i + 3; ++k) points[k] = points[k] + Point{0, 0, 10.0 * (i + 1)};
  const auto last = self_intersections(points, triangles, 9);
  EXPECT_THAT(last,
              testing::ElementsAre(std::array{kCount - 3, kCount - 2}, std::array{kCount - 3, kCount - 1},
                                   std::array{kCount - 2, kCount - 1}));
  const std::atomic<bool> interrupt{true};
  EXPECT_THROW(self_intersections(points, triangles, 9, &interrupt), Interrupted);
}

}  // namespace
}  // namespace weft::meshing::closed_surface_test

// Tests of the location of points: by the rule alone, whatever the hint, the order of tets and what is
// missing.
#include "meshing/fields/tet_locator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "meshing/base/box.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/tet_tables.h"
#include "tests/support/meshes.h"
#include "tests/support/slivers.h"

namespace weft::meshing::tet_locator_test {
namespace {

/// Two that touch and are not joined.
MeshData cubes_side_by_side() {
  MeshData both = support::unit_cube(4);
  const auto first = static_cast<std::uint32_t>(both.points.size());
  const MeshData other = both;
  for (const Point& p : other.points) both.points.push_back(p + Vec{1, 0, 0});
  for (const Tet& t : other.tets)
    both.tets.push_back({t[0] + first, t[1] + first, t[2] + first, t[3] + first});
  return both;
}

MeshData meshes(int which) {
  if (which == 0) return support::with_slivers(support::turned(support::unit_cube(4)), 1);
  if (which == 1) return support::touching_cells(4, 3);
  if (which == 2) return cubes_side_by_side();
  return support::with_slivers(support::ball(3, 3), 2);
}

TetLocator locator_of(const MeshData& mesh) { return {mesh, build_adjacency(mesh.tets, mesh.points.size())}; }

/// Vertices, middles of edges and faces, which rounding puts on either side, and points anywhere.
std::vector<Point> points_about(const MeshData& mesh) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  const Box box = box_of(mesh.points);
  std::vector<Point> points(mesh.points.begin(),
                            mesh.points.begin() + std::min<std::ptrdiff_t>(60, std::ssize(mesh.points)));
  for (int i = 0; i < 100; ++i) {
    const Tet& tet = mesh.tets[random() % mesh.tets.size()];
    const Point &a = mesh.points[tet[0]], &b = mesh.points[tet[1]], &c = mesh.points[tet[2]];
    points.push_back(midpoint(a, b));
    points.push_back((1.0 / 3) * (a + b + c));
    const Vec size = box.size();
    points.push_back(box.lo + Vec{share(random) * size.x, share(random) * size.y, share(random) * size.z});
  }
  return points;
}

bool holds(const MeshData& mesh, const Tet& tet, const Point& p) {
  return std::ranges::all_of(kTetFaces, [&](const auto& f) {
    const auto at = [&](int i) { return mesh.points[tet[static_cast<std::size_t>(i)]]; };
    return orientation(at(f[0]), at(f[1]), at(f[2]), p) >= 0;
  });
}

void expect_same(const MeshData& mesh, const TetLocator::Place& place, const MeshData& other,
                 const TetLocator::Place& expected) {
  EXPECT_EQ(mesh.tets[place.tet], other.tets[expected.tet]);
  EXPECT_EQ(place.at, expected.at);
  EXPECT_EQ(place.distance2, expected.distance2);
  EXPECT_EQ(place.inside, expected.inside);
}

class TetLocatorOf : public testing::TestWithParam<int> {};

TEST_P(TetLocatorOf, FindsTheLargestTetThatHoldsAPoint) {
  const MeshData mesh = meshes(GetParam());
  const TetLocator locator = locator_of(mesh);
  for (const Point& p : points_about(mesh)) {
    double largest = 0;
    for (const Tet& t : mesh.tets)
      if (holds(mesh, t, p))
        largest = std::max(
            largest, six_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]));
    const TetLocator::Place place = locator.locate(p, TetLocator::kNoHint);
    const Tet& t = mesh.tets[place.tet];
    EXPECT_EQ(place.inside, largest > 0);
    EXPECT_EQ(place.inside, holds(mesh, t, p));
    if (place.inside) {
      EXPECT_EQ(six_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]),
                largest);
    }
    Point read;
    for (std::size_t i = 0; i < 4; ++i) read += place.at[i] * mesh.points[t[i]];
    EXPECT_NEAR(norm2(read - p), place.distance2, 1e-9);
  }
}

TEST_P(TetLocatorOf, GivesTheSamePlaceFromAnyHintAndInAnyOrderOfTets) {
  const MeshData mesh = meshes(GetParam());
  MeshData reordered = mesh;
  std::mt19937 random(5);
  std::ranges::shuffle(reordered.tets, random);
  const TetLocator locator = locator_of(mesh), other = locator_of(reordered);
  for (const Point& p : points_about(mesh)) {
    const TetLocator::Place expected = locator.locate(p, TetLocator::kNoHint);
    for (int i = 0; i < 8; ++i) {
      const auto hint = static_cast<std::uint32_t>(random() % mesh.tets.size());
      expect_same(mesh, locator.locate(p, hint), mesh, expected);
      expect_same(reordered, other.locate(p, hint), mesh, expected);
    }
  }
}

TEST_P(TetLocatorOf, GivesTheSamePlaceWhereWhatIsFartherOffIsMissing) {
  const MeshData mesh = meshes(GetParam());
  const TetLocator locator = locator_of(mesh);
  for (const Point& p : points_about(mesh)) {
    const TetLocator::Place expected = locator.locate(p, TetLocator::kNoHint);
    const Box near = Box{p, p}.grown(1e-3 + 1.001 * std::sqrt(expected.distance2));
    MeshData part;
    part.points = mesh.points;
    std::ranges::copy_if(mesh.tets, std::back_inserter(part.tets), [&](const Tet& tet) {
      Box box;
      for (const std::uint32_t v : tet) box.include(mesh.points[v]);
      return box.meets(near);
    });
    expect_same(part, locator_of(part).locate(p, TetLocator::kNoHint), mesh, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, TetLocatorOf, testing::Range(0, 4));

TEST(TetLocator, ReadsAFlatTetOnItsFaces) {
  // A height of 1e-17 of its size: weights by volumes would be rounding alone.
  const MeshData mesh =
      support::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 1e-17}}, {{0, 1, 2, 3}});
  const Point p{0.5, 0.25, 0};
  const TetLocator::Place place = locator_of(mesh).locate(p, TetLocator::kNoHint);
  EXPECT_TRUE(place.inside);
  Point read;
  for (std::size_t i = 0; i < 4; ++i) read += place.at[i] * mesh.points[i];
  EXPECT_LT(norm(read - p), 1e-15);
}

}  // namespace
}  // namespace weft::meshing::tet_locator_test

// Delaunay tetrahedrisation of random and of highly cospherical points.
#include "meshing/initial/grid/delaunay.h"

#include <gtest/gtest.h>

#include <random>

#include "meshing/mesh/predicates.h"

namespace weft::meshing::delaunay_test {
namespace {

double volume(const TetGrid& grid) {
  double sum = 0;
  for (const auto& t : grid.tets)
    if (t.v[0] != t.v[1])
      sum +=
          six_volume(grid.points[t.v[0]], grid.points[t.v[1]], grid.points[t.v[2]], grid.points[t.v[3]]) / 6;
  return sum;
}

/// Positive tets, symmetric neighbours, and no vertex of a neighbour inside a circumsphere.
void expect_delaunay(const TetGrid& grid) {
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    const auto& tet = grid.tets[t];
    ASSERT_TRUE(grid.positive(tet.v));
    for (std::uint32_t f = 0; f < 4; ++f) {
      if (tet.n[f] == kNothing) continue;
      const auto& other = grid.tets[tet.n[f] >> 2];
      ASSERT_EQ(other.n[tet.n[f] & 3], 4 * t + f);
      const Point& apex = grid.points[other.v[tet.n[f] & 3]];
      const auto& p = grid.points;
      ASSERT_LE(in_sphere(p[tet.v[0]], p[tet.v[1]], p[tet.v[2]], p[tet.v[3]], apex), 0);
    }
  }
}

TEST(Delaunay, OfRandomPointsFillsTheBox) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-1, 1);
  std::vector<Point> points;
  for (int i = 0; i < 500; ++i) points.push_back({at(random), at(random), at(random)});
  const TetGrid grid = delaunay_in_box(points);
  expect_delaunay(grid);
  const Vec size = grid.points[507] - grid.points[500];
  EXPECT_NEAR(volume(grid), size.x * size.y * size.z, 1e-9);
}

TEST(Delaunay, OfALatticeIsValidThoughAllIsCospherical) {
  std::vector<Point> points;
  for (int i = 0; i < 216; ++i) points.push_back({i % 6 * 0.1, i / 6 % 6 * 0.1, i / 36 * 0.1});
  const TetGrid grid = delaunay_in_box(points);
  expect_delaunay(grid);
  for (std::uint32_t v = 0; v < points.size(); ++v) EXPECT_NE(grid.vertex_tet[v], kNothing);
}

TEST(Delaunay, OfCoplanarPoints) {
  std::vector<Point> points;
  for (int i = 0; i < 25; ++i) points.push_back({i % 5 * 1.0, i / 5 * 1.0, 0});
  expect_delaunay(delaunay_in_box(points));
}

}  // namespace
}  // namespace weft::meshing::delaunay_test

// Grids that flips or boundary recovery have made other than Delaunay.
#include "meshing/initial/grid/flip_to_delaunay.h"

#include <gtest/gtest.h>

#include <random>

#include "meshing/initial/grid/delaunay.h"
#include "meshing/initial/grid/grid_of_mesh.h"
#include "meshing/initial/initial_grid.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/mesh/predicates.h"
#include "tests/meshing/initial/initial_support.h"

namespace weft::meshing::flip_to_delaunay_test {
namespace {

/// Faces, but for facets, beyond which a vertex is within the circumsphere.
std::size_t count_conflicts(const TetGrid& grid) {
  std::size_t count = 0;
  for (const TetGrid::Tet& t : grid.tets)
    for (int f = 0; f < 4; ++f) {
      if (t.v[0] == t.v[1] || t.n[f] == kNothing || t.facet[f] != kNothing) continue;
      const auto& p = grid.points;
      const Point& beyond = p[grid.tets[t.n[f] >> 2].v[t.n[f] & 3]];
      count += in_sphere(p[t.v[0]], p[t.v[1]], p[t.v[2]], p[t.v[3]], beyond) > 0;
    }
  return count;
}

/// Exchanges two tets for three at one face in `every`, where that is possible.
void spoil(TetGrid& grid, std::uint32_t every) {
  for (std::uint32_t t = 0; t < grid.tets.size(); t += every) {
    const std::uint32_t n = grid.tets[t].n[0];
    if (!grid.alive(t) || n == kNothing) continue;
    const Face3 w = grid.face(t, 0);
    std::vector<Tet4> fresh;
    for (int i = 0; i < 3; ++i)
      fresh.push_back({w[i], w[(i + 1) % 3], grid.tets[n >> 2].v[n & 3], grid.tets[t].v[0]});
    if (!grid.positive(fresh[0]) || !grid.positive(fresh[1]) || !grid.positive(fresh[2])) continue;
    const std::array<std::uint32_t, 2> old = {t, n >> 2};
    grid.replace(old, fresh);
  }
}

TEST(FlipToDelaunay, UndoesFlips) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-1, 1);
  std::vector<Point> points;
  for (int i = 0; i < 500; ++i) points.push_back({at(random), at(random), at(random)});
  TetGrid grid = delaunay_in_box(points);
  spoil(grid, 40);
  EXPECT_GT(count_conflicts(grid), 50u);
  flip_to_delaunay(grid);
  EXPECT_EQ(count_conflicts(grid), 0u);
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t)
    ASSERT_TRUE(!grid.alive(t) || grid.positive(grid.tets[t].v));
}

TEST(FlipToDelaunay, KeepsFacetsAndVolumes) {
  const MeshData start = make_initial_grid(close_surface(support::torus(60, 36), {}), {}).mesh;
  GridOfMesh filled(start);
  const std::size_t before = count_conflicts(filled.grid);
  flip_to_delaunay(filled.grid);
  EXPECT_LT(count_conflicts(filled.grid), before / 4);
  const CheckReport now = check_mesh(filled.take()), then = check_mesh(start);
  EXPECT_TRUE(now.ok());
  EXPECT_EQ(now.area_by_ref, then.area_by_ref);
  EXPECT_NEAR(now.volume_by_ref.begin()->second, then.volume_by_ref.begin()->second, 1e-12);
}

TEST(FlipToDelaunay, AnInterruptionComesBeforeTheNextFlip) {
  const MeshData start = make_initial_grid(close_surface(support::torus(40, 24), {}), {}).mesh;
  GridOfMesh filled(start);
  const std::size_t before = count_conflicts(filled.grid);
  const std::atomic<bool> interrupt{true};
  flip_to_delaunay(filled.grid, &interrupt);
  EXPECT_EQ(count_conflicts(filled.grid), before);
}

}  // namespace
}  // namespace weft::meshing::flip_to_delaunay_test

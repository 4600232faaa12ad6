// Worst tets get better, and what is inside the walls stays the same.
#include "meshing/initial/recovery/improve_tets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "meshing/initial/grid/delaunay.h"
#include "meshing/initial/grid/star_cavity.h"
#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing::improve_tets_test {
namespace {

struct Totals {
  double volume = 0, worst = 1;
  std::size_t facets = 0;
};

Totals totals(const TetGrid& grid) {
  Totals sum;
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    const Tet4& v = grid.tets[t].v;
    sum.volume += six_volume(grid.points[v[0]], grid.points[v[1]], grid.points[v[2]], grid.points[v[3]]);
    sum.worst = std::min(sum.worst, grid.shape(v));
    sum.facets += static_cast<std::size_t>(std::count_if(grid.tets[t].facet.begin(), grid.tets[t].facet.end(),
                                                         [](auto f) { return f != kNothing; }));
  }
  return sum;
}

/// A Delaunay grid of random points in a box, a tenth of whose inner faces are walls.
Recovery random_grid(unsigned seed, unsigned walls_in_ten) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> at(0, 1);
  std::vector<Point> points;
  for (int i = 0; i < 200; ++i) points.push_back({at(random), at(random), 0.1 * at(random)});
  Recovery r;
  r.grid = delaunay_in_box(points);
  for (std::uint32_t t = 0; t < r.grid.tets.size(); ++t)
    for (int f = 0; f < 4; ++f)
      if (r.grid.tets[t].n[f] != kNothing && random() % 10 < walls_in_ten) r.grid.set_facet(t, f, 0);
  return r;
}

TEST(ImproveTets, RaisesTheWorstAndKeepsVolumeAndWalls) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Recovery r = random_grid(seed, seed % 2);
    const Totals before = totals(r.grid);
    improve_tets(r.grid);
    const Totals after = totals(r.grid);
    EXPECT_NEAR(after.volume, before.volume, 1e-12 * before.volume) << seed;
    EXPECT_EQ(after.facets, before.facets) << seed;
    EXPECT_GE(after.worst, seed % 2 ? before.worst : 10 * before.worst) << seed;
  }
}

TEST(StarCavity, DoesNotPassWalls) {
  Recovery r = random_grid(1, 10);
  StarCavity cavity(r.grid);
  for (std::uint32_t t = 0; t < 100; ++t) {
    if (!r.grid.alive(t)) continue;
    cavity.begin(kNothing, std::span(&t, 1), {}, {});
    Star star;
    for (std::uint32_t v = 0; v < 20; ++v) cavity.improve(star, v);
    EXPECT_LE(star.old.size(), 1u);
  }
}

TEST(StarCavity, FillsTheSameSpace) {
  Recovery r = random_grid(2, 0);
  StarCavity cavity(r.grid);
  const double volume = totals(r.grid).volume;
  std::mt19937 random(1);
  int filled = 0;
  for (int i = 0; i < 200; ++i) {
    const auto t = static_cast<std::uint32_t>(random() % r.grid.tets.size());
    if (!r.grid.alive(t)) continue;
    cavity.begin(kNothing, std::span(&t, 1), {}, {});
    Star star;
    star.worst = r.grid.shape(r.grid.tets[t].v);
    for (const std::uint32_t v :
         Tet4(r.grid.tets[r.grid.tets[t].n[0] == kNothing ? t : r.grid.tets[t].n[0] >> 2].v))
      cavity.improve(star, v);
    if (star.fresh.empty()) continue;
    fill(r.grid, star);
    ++filled;
    ASSERT_NEAR(totals(r.grid).volume, volume, 1e-12 * volume);
  }
  EXPECT_GT(filled, 10);
}

}  // namespace
}  // namespace weft::meshing::improve_tets_test

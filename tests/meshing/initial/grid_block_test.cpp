// A grid in blocks, changed there, is whole again afterwards.
#include "meshing/initial/grid/grid_block.h"

#include <gtest/gtest.h>

#include <set>

#include "meshing/initial/grid/grid_of_mesh.h"
#include "meshing/initial/initial_grid.h"
#include "meshing/mesh/check_mesh.h"
#include "tests/meshing/initial/initial_support.h"

namespace weft::meshing::grid_block_test {
namespace {

MeshData start() { return make_initial_grid(close_surface(support::ball(0.15), {}), {}).mesh; }

/// Puts a vertex into the middle of every tet that is not frozen.
void divide_inner_tets(GridBlock& block) {
  TetGrid& grid = block.grid;
  const auto count = static_cast<std::uint32_t>(grid.tets.size());
  for (std::uint32_t t = block.frozen; t < count; ++t) {
    const Tet4 w = grid.tets[t].v;
    const auto& p = grid.points;
    const std::uint32_t v = grid.add_point(0.25 * (p[w[0]] + p[w[1]] + p[w[2]] + p[w[3]]));
    std::vector<Tet4> fresh;
    ASSERT_TRUE(grid.star(std::span(&t, 1), v, fresh));
    grid.fill_star(std::span(&t, 1), fresh);
  }
}

TEST(GridBlock, HasEveryTetOnce) {
  const GridOfMesh whole(start());
  std::set<std::uint32_t> seen;
  std::size_t frozen = 0;
  for (const GridBlock& b : divide(whole.grid, 5)) {
    EXPECT_NEAR(static_cast<double>(b.tets.size()), static_cast<double>(whole.grid.tets.size()) / 5, 1);
    EXPECT_EQ(b.grid.tets.size(), b.tets.size());
    seen.insert(b.tets.begin(), b.tets.end());
    frozen += b.frozen;
  }
  EXPECT_EQ(seen.size(), whole.grid.tets.size());
  EXPECT_GT(frozen, 0u);
}

TEST(GridBlock, FreezesWhatBordersOnOthers) {
  const GridOfMesh whole(start());
  for (const GridBlock& b : divide(whole.grid, 3))
    for (std::uint32_t t = 0; t < b.tets.size(); ++t) {
      bool lost = false;
      for (int f = 0; f < 4; ++f)
        lost |= (b.grid.tets[t].n[f] == kNothing) != (whole.grid.tets[b.tets[t]].n[f] == kNothing);
      ASSERT_EQ(lost, t < b.frozen);
    }
}

TEST(GridBlock, GoesBackUnchanged) {
  const MeshData mesh = start();
  GridOfMesh whole(mesh);
  join(whole.grid, divide(whole.grid, 4));
  const MeshData again = whole.take();
  EXPECT_EQ(again.points, mesh.points);
  EXPECT_EQ(again.tets, mesh.tets);
}

TEST(GridBlock, GoesBackWithItsChanges) {
  const MeshData mesh = start();
  GridOfMesh whole(mesh);
  std::vector<GridBlock> blocks = divide(whole.grid, 4);
  std::size_t divided = 0;
  for (GridBlock& b : blocks) {
    divided += b.tets.size() - b.frozen;
    divide_inner_tets(b);
  }
  const std::vector<JoinedNumbers> numbers = join(whole.grid, blocks);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (std::size_t v = 0; v < numbers[b].points.size(); ++v)
      ASSERT_EQ(whole.grid.points[numbers[b].points[v]], blocks[b].grid.points[v]);
  for (std::uint32_t v = 0; v < whole.grid.points.size(); ++v)
    ASSERT_GE(whole.grid.local_index(whole.grid.vertex_tet[v], v), 0);
  const MeshData result = whole.take();
  EXPECT_EQ(result.tets.size(), mesh.tets.size() + 3 * divided);
  const CheckReport now = check_mesh(result), before = check_mesh(mesh);
  EXPECT_TRUE(now.ok());
  EXPECT_NEAR(now.volume_by_ref.begin()->second, before.volume_by_ref.begin()->second, 1e-12);
}

}  // namespace
}  // namespace weft::meshing::grid_block_test

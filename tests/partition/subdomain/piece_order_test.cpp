// Runs of tets in the order of pieces are compact whatever the order of the input.
#include "partition/subdomain/piece_order.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "partition/subdomain/background_store.h"
#include "tests/partition/scenes.h"

namespace weft::partition::piece_order_test {
namespace {

using namespace weft::support;

/// The mean number of vertices of the runs of kTetsOfPiece tets.
double vertices_of_runs(const meshing::MeshData& mesh, const std::vector<std::uint32_t>& order) {
  std::size_t vertices = 0, runs = 0;
  for (std::size_t first = 0; first < order.size(); first += kTetsOfPiece, ++runs) {
    std::set<std::uint32_t> of_run;
    for (std::size_t i = first; i < std::min(order.size(), first + kTetsOfPiece); ++i)
      of_run.insert(mesh.tets[order[i]].begin(), mesh.tets[order[i]].end());
    vertices += of_run.size();
  }
  return static_cast<double>(vertices) / static_cast<double>(runs);
}

TEST(PieceOrder, MakesCompactRunsOfShuffledTets) {
  for (const double stretch : {1.0, 100.0}) {
    meshing::MeshData mesh = unit_cube(16);
    shuffle(mesh, 5);
    for (meshing::Point& p : mesh.points) p.x *= stretch;
    const std::vector<std::uint32_t> order = piece_order(mesh.points, mesh.tets);
    std::vector<std::uint32_t> sorted = order, all(mesh.tets.size());
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_GT(vertices_of_runs(mesh, all), 1000) << "the input's order says nothing";
    EXPECT_LT(vertices_of_runs(mesh, order), 180) << "a cube of 512 tets has 150";
    std::ranges::sort(sorted);
    EXPECT_EQ(sorted, all);
  }
}

TEST(PieceOrder, LeavesOnePieceAsItIs) {
  const meshing::MeshData mesh = unit_cube(4);
  ASSERT_LE(mesh.tets.size(), kTetsOfPiece);
  std::vector<std::uint32_t> all(mesh.tets.size());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(piece_order(mesh.points, mesh.tets), all);
  EXPECT_TRUE(piece_order({}, {}).empty());
}

}  // namespace
}  // namespace weft::partition::piece_order_test

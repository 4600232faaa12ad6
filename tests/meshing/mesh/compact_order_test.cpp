// Runs of tets are compact whatever the order of the input.
#include "meshing/mesh/compact_order.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "tests/support/meshes.h"

namespace weft::meshing::compact_order_test {
namespace {

using namespace weft::support;

constexpr std::size_t kRun = 512;

/// The mean number of vertices of the runs of kRun tets.
double vertices_of_runs(const MeshData& mesh, const std::vector<std::uint32_t>& order) {
  std::size_t vertices = 0, runs = 0;
  for (std::size_t first = 0; first < order.size(); first += kRun, ++runs) {
    std::set<std::uint32_t> of_run;
    for (std::size_t i = first; i < std::min(order.size(), first + kRun); ++i)
      of_run.insert(mesh.tets[order[i]].begin(), mesh.tets[order[i]].end());
    vertices += of_run.size();
  }
  return static_cast<double>(vertices) / static_cast<double>(runs);
}

TEST(CompactOrder, MakesCompactRunsOfShuffledTets) {
  for (const double stretch : {1.0, 100.0}) {
    MeshData mesh = unit_cube(16);
    shuffle(mesh, 5);
    for (Point& p : mesh.points) p.x *= stretch;
    const std::vector<std::uint32_t> order = compact_order(mesh.points, mesh.tets, kRun);
    std::vector<std::uint32_t> sorted = order, all(mesh.tets.size());
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_GT(vertices_of_runs(mesh, all), 1000) << "the input's order says nothing";
    EXPECT_LT(vertices_of_runs(mesh, order), 180) << "a cube of 512 tets has 150";
    std::ranges::sort(sorted);
    EXPECT_EQ(sorted, all);
  }
}

TEST(CompactOrder, LeavesOneRunAsItIs) {
  const MeshData mesh = unit_cube(4);
  ASSERT_LE(mesh.tets.size(), kRun);
  std::vector<std::uint32_t> all(mesh.tets.size());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(compact_order(mesh.points, mesh.tets, kRun), all);
  EXPECT_TRUE(compact_order({}, {}, kRun).empty());
}

}  // namespace
}  // namespace weft::meshing::compact_order_test

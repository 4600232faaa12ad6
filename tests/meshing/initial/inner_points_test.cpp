// Points within a volume: as dense as sizes say, in a grid that stays whole.
#include "meshing/initial/inner_points.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "meshing/initial/grid/grid_of_mesh.h"
#include "meshing/initial/initial_grid.h"
#include "meshing/initial/point_distribution.h"
#include "meshing/mesh/check_mesh.h"
#include "tests/meshing/initial/initial_support.h"

namespace weft::meshing::inner_points_test {
namespace {

using support::ball;
using support::box_surface;
using support::together;
using support::torus;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

MeshData grid_of(const MeshData& surface, bool keep_enclosed = false) {
  return make_initial_grid(close_surface(surface, {}), {keep_enclosed}).mesh;
}

MeshData with_points(const MeshData& start, double growth, double largest = kNoLimit,
                     const std::atomic<bool>* interrupt = nullptr, int threads = 1) {
  const std::vector<SizeSource> sources = PointDistribution(start, growth, 0).size_sources();
  GridOfMesh filled(start);
  insert_inner_points(filled.grid, sources, spread_sizes(start, sources), largest, threads, interrupt);
  return filled.take();
}

/// Same volumes, areas and triangles, and a mesh that conforms.
void expect_whole(const MeshData& mesh, const MeshData& start) {
  const CheckReport now = check_mesh(mesh), before = check_mesh(start);
  EXPECT_TRUE(now.ok());
  EXPECT_EQ(now.area_by_ref, before.area_by_ref);
  ASSERT_EQ(now.volume_by_ref.size(), before.volume_by_ref.size());
  for (const auto& [ref, volume] : before.volume_by_ref)
    EXPECT_NEAR(now.volume_by_ref.at(ref), volume, 1e-12);
  EXPECT_EQ(mesh.triangles.size(), start.triangles.size());
}

TEST(GridOfMesh, IsTheMeshAgain) {
  const MeshData start = grid_of(
      together(box_surface({-2, -2, -2}, {2, 2, 2}, 3), box_surface({-1, -1, -1}, {1, 1, 1}, 2)), true);
  const MeshData mesh = GridOfMesh(start).take();
  EXPECT_EQ(mesh.points, start.points);
  EXPECT_EQ(mesh.tets, start.tets);
  EXPECT_EQ(mesh.tet_refs, start.tet_refs);
  EXPECT_EQ(mesh.triangles, start.triangles);
}

TEST(GridOfMesh, LeavesOutPointsThatNoTetHolds) {
  MeshData start = grid_of(box_surface({}, {1, 1, 1}, 2));
  start.points.insert(start.points.begin(), {5, 5, 5});
  start.point_refs.insert(start.point_refs.begin(), 9);
  for (auto& t : start.tets)
    for (std::uint32_t& v : t) ++v;
  for (auto& t : start.triangles)
    for (std::uint32_t& v : t) ++v;
  const MeshData mesh = GridOfMesh(start).take();
  EXPECT_EQ(mesh.points.size() + 1, start.points.size());
  EXPECT_TRUE(check_mesh(mesh).ok());
}

TEST(InnerPoints, AreAsDenseAsSizesSay) {
  const MeshData start = grid_of(box_surface({}, {1, 1, 1}, 10));
  const MeshData mesh = with_points(start, 1);
  expect_whole(mesh, start);
  const double size = (0.1 * 4 + 0.1 * std::sqrt(2.0) * 2) / 6;  // about, in the middle of a side
  const auto inside = static_cast<double>(mesh.points.size() - start.points.size());
  EXPECT_GT(inside, 0.6 / (size * size * size));
  EXPECT_LT(inside, 1.8 / (size * size * size));
  for (std::size_t v = start.points.size(); v < mesh.points.size(); ++v)
    for (std::size_t u = 0; u < v; ++u) ASSERT_GT(norm(mesh.points[v] - mesh.points[u]), 0.5 * size);
}

TEST(InnerPoints, GrowApartUpToTheLargestSize) {
  const MeshData start = grid_of(ball(0.1));
  const std::size_t constant = with_points(start, 1).points.size(),
                    growing = with_points(start, 1.5).points.size();
  EXPECT_LT(growing - start.points.size(), (constant - start.points.size()) / 2);
  EXPECT_GT(with_points(start, 1.5, 0.12).points.size(), growing);
}

TEST(InnerPoints, StayInTheirVolume) {
  const MeshData start = grid_of(together(box_surface({-2, -2, -2}, {2, 2, 2}, 6), ball(0.3)), true);
  const MeshData mesh = with_points(start, 1.2);
  expect_whole(mesh, start);
  EXPECT_GT(mesh.points.size(), start.points.size());
}

TEST(InnerPoints, FillATorusThatRecoveryLeftOtherThanDelaunay) {
  const MeshData start = grid_of(torus(60, 36));
  const MeshData mesh = with_points(start, 1.3);
  expect_whole(mesh, start);
  EXPECT_GT(mesh.points.size(), start.points.size() + 1000);
}

MeshData with_threads(const MeshData& start, int threads) {
  return with_points(start, 1.2, kNoLimit, nullptr, threads);
}

TEST(InnerPoints, ThreadsPutAsManyAsOne) {
  const MeshData start = grid_of(ball(0.04));
  const MeshData by_one = with_threads(start, 1);
  const auto inside = static_cast<double>(by_one.points.size() - start.points.size());
  for (const int threads : {2, 3}) {
    const MeshData mesh = with_threads(start, threads);
    expect_whole(mesh, start);
    EXPECT_NE(mesh.points, by_one.points);  // there were blocks
    EXPECT_NEAR(static_cast<double>(mesh.points.size() - start.points.size()), inside, 0.02 * inside);
  }
}

TEST(InnerPoints, AreTheSameForTheSameNumberOfThreads) {
  const MeshData start = grid_of(ball(0.04));
  const MeshData mesh = with_threads(start, 3), again = with_threads(start, 3);
  EXPECT_EQ(mesh.points, again.points);
  EXPECT_EQ(mesh.tets, again.tets);
}

TEST(InnerPoints, ThreadsThatAreInterruptedLeaveTheGridWhole) {
  const MeshData start = grid_of(ball(0.04));
  const std::atomic<bool> interrupt{true};
  const MeshData mesh = with_points(start, 1.2, kNoLimit, &interrupt, 3);
  expect_whole(mesh, start);
  EXPECT_EQ(mesh.points.size(), start.points.size());
}

TEST(InnerPoints, AnInterruptionLeavesTheGridWhole) {
  const MeshData start = grid_of(ball(0.2));
  const std::atomic<bool> interrupt{true};
  const MeshData mesh = with_points(start, 1, kNoLimit, &interrupt);
  expect_whole(mesh, start);
  EXPECT_EQ(mesh.points.size(), start.points.size());
}

}  // namespace
}  // namespace weft::meshing::inner_points_test

// Polygons become triangles that do not fold over, whichever corner comes first.
#include "meshing/mesh/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace weft::meshing {
namespace {

double area(const MeshData& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles)
    sum += norm(cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]])) / 2;
  return sum;
}

/// The triangles of one polygon over all points that begins with corner `first`.
MeshData cut(const std::vector<Point>& points, std::uint32_t first) {
  std::vector<std::uint32_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0u);
  std::ranges::rotate(corners, corners.begin() + first);
  MeshData mesh;
  Polygons polygons;
  polygons.add(corners, 7, mesh);
  mesh.points = points;  // they may follow their use
  polygons.unfold(mesh);
  return mesh;
}

TEST(Polygons, ConcaveOnesDoNotFoldOver) {
  const std::vector<Point> l = {{0, 0, 1}, {2, 0, 1}, {2, 1, 1}, {1, 1, 1}, {1, 2, 1}, {0, 2, 1}};
  for (std::uint32_t first = 0; first < l.size(); ++first) {
    const MeshData mesh = cut(l, first);
    ASSERT_EQ(mesh.triangles.size(), 4u);
    EXPECT_EQ(mesh.triangle_refs, std::vector<std::int32_t>(4, 7));
    EXPECT_NEAR(area(mesh), 3, 1e-12) << "first corner " << first;
    for (const Triangle& t : mesh.triangles)
      EXPECT_GE(cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]).z, 0);
  }
}

TEST(Polygons, StarsInASlantedPlane) {
  std::vector<Point> star;
  double expected = 0;
  for (int i = 0; i < 14; ++i) {
    const double r = i % 2 ? 0.2 : 1, angle = std::numbers::pi * i / 7;
    star.push_back({r * std::cos(angle), r * std::sin(angle), r * std::cos(angle)});
    expected += std::sqrt(2.0) * 0.2 * std::sin(std::numbers::pi / 7) / 2;
  }
  for (std::uint32_t first = 0; first < star.size(); ++first)
    EXPECT_NEAR(area(cut(star, first)), expected, 1e-12) << "first corner " << first;
}

TEST(Polygons, ConvexOnesStayFans) {
  const std::vector<Point> pentagon = {{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 3, 0}, {-1, 1, 0}};
  EXPECT_EQ(cut(pentagon, 0).triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

}  // namespace
}  // namespace weft::meshing

// Whether a boundary is curved, by the directions of its triangles.
#include "meshing/geometry/surface/face_directions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/meshes.h"

namespace weft::meshing::face_directions_test {
namespace {

FaceDirections directions_of(const MeshData& mesh, std::size_t begin = 0, std::size_t step = 1) {
  FaceDirections directions;
  for (std::size_t t = begin; t < mesh.triangles.size(); t += step) {
    const auto& [a, b, c] = mesh.triangles[t];
    directions.add(mesh.triangle_refs[t], mesh.points[a], mesh.points[b], mesh.points[c]);
  }
  return directions;
}

/// Two unit squares of one reference that meet along an edge and turn by an angle.
FaceDirections bent(double degrees, std::int32_t second_ref = 1) {
  const double angle = degrees * std::numbers::pi / 180;
  FaceDirections directions;
  directions.add(1, {0, 0, 0}, {1, 0, 0}, {1, 1, 0});
  directions.add(second_ref, {0, 0, 0}, {-std::cos(angle), 0, std::sin(angle)}, {0, 1, 0});
  return directions;
}

TEST(FaceDirections, OfABoxAreThoseOfPlanesHoweverItIsTurnedAndScaled) {
  MeshData box = support::unit_cube(3);
  EXPECT_FALSE(directions_of(box).may_curve(45));
  const double c = std::cos(0.7), s = std::sin(0.7);
  for (Point& p : box.points) p = {1e-3 * (c * p.x - s * p.y), 1e-3 * (s * p.x + c * p.y), 1e3 + 1e-3 * p.z};
  EXPECT_FALSE(directions_of(box).may_curve(45));
}

TEST(FaceDirections, OfRoundBodiesAreMany) {
  EXPECT_TRUE(directions_of(support::ball(2, 2)).may_curve(45));
  EXPECT_TRUE(directions_of(support::cylinder(16, 2, 2, 1)).may_curve(45));
  EXPECT_TRUE(directions_of(support::cylinder(200, 2, 2, 1)).may_curve(45));
}

TEST(FaceDirections, CurveBelowTheRidgeAngleWithinAReference) {
  EXPECT_TRUE(bent(30).may_curve(45));
  EXPECT_TRUE(bent(1).may_curve(45));
  EXPECT_FALSE(bent(60).may_curve(45));
  EXPECT_TRUE(bent(60).may_curve(70));
  EXPECT_FALSE(bent(30, 2).may_curve(45));
  EXPECT_FALSE(bent(0.01).may_curve(45));
}

TEST(FaceDirections, OfSharesMergeInAnyOrder) {
  for (const MeshData& mesh : {support::unit_cube(3), support::ball(2, 2), support::cylinder(5, 2, 2, 1)}) {
    const FaceDirections all = directions_of(mesh);
    FaceDirections forth = directions_of(mesh, 0, 3), back = directions_of(mesh, 2, 3);
    for (const std::size_t share : {1u, 2u}) forth.merge(directions_of(mesh, share, 3));
    for (const std::size_t share : {0u, 1u}) back.merge(directions_of(mesh, share, 3));
    EXPECT_EQ(forth.may_curve(45), all.may_curve(45));
    EXPECT_EQ(back.may_curve(45), all.may_curve(45));
  }
}

TEST(MayCurve, LeavesOutTrianglesWithoutPoints) {
  MeshData box = support::unit_cube(2);
  box.triangles[3] = {0, 1, 4000000000u};
  EXPECT_FALSE(may_curve(box));
  box.triangle_refs.pop_back();
  EXPECT_FALSE(may_curve(box));
}

TEST(FaceDirections, OfDegenerateTrianglesAreNone) {
  FaceDirections directions;
  directions.add(1, {0, 0, 0}, {1, 0, 0}, {2, 0, 0});
  directions.add(1, {0, 0, 0}, {0, 0, 0}, {0, 0, 0});
  EXPECT_FALSE(directions.may_curve(45));
}

}  // namespace
}  // namespace weft::meshing::face_directions_test

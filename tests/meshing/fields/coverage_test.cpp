// What of a mesh lies outside another one.
#include "meshing/fields/coverage.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace weft::meshing::coverage_test {
namespace {

using support::unit_cube;

/// The unit cube in n^3 cells, as far as `length` in x.
MeshData cube_to(double length, std::uint32_t n) {
  MeshData mesh = unit_cube(n);
  for (Point& p : mesh.points) p.x *= length;
  return mesh;
}

TEST(Uncovered, IsNothingOfTheSameDomain) {
  EXPECT_EQ(uncovered(unit_cube(3), unit_cube(5)).vertices, 0u);
  EXPECT_EQ(uncovered(unit_cube(5), unit_cube(3)).farthest, 0);
}

TEST(Uncovered, CountsVerticesThatAreFarOutside) {
  const Uncovered found = uncovered(cube_to(0.5, 4), unit_cube(4));
  EXPECT_EQ(found.vertices, 2 * 25u);  // at x = 0.75 and 1
  EXPECT_NEAR(found.farthest, 0.5, 1e-12);
}

TEST(Uncovered, IsNotWhatIsOutsideByLittle) {
  // Tets of size 0.43: as far off as the chords of a curved boundary are.
  EXPECT_EQ(uncovered(cube_to(0.97, 4), unit_cube(4)).vertices, 0u);
  EXPECT_EQ(uncovered(cube_to(0.94, 4), unit_cube(4)).vertices, 25u);
}

}  // namespace
}  // namespace weft::meshing::coverage_test

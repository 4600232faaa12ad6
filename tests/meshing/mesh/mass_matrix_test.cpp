// Tests of the mass matrix and its solver.
#include "meshing/mesh/mass_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/support/meshes.h"

namespace weft::meshing::mass_matrix_test {
namespace {

TEST(MassMatrix, LumpedMassesAddUpToTheVolume) {
  const MassMatrix mass(support::layered_box(3, 2, 2));
  EXPECT_NEAR(std::accumulate(mass.lumped().begin(), mass.lumped().end(), 0.0), 2, 1e-14);
}

TEST(MassMatrix, SolvesForTheFieldWhoseIntegralsItIsGiven) {
  // Flat cells: the convergence must not know the anisotropy.
  MeshData mesh = support::unit_cube(5);
  support::jitter_interior(mesh, 0.04);
  for (Point& p : mesh.points) p.z *= 1e-5;
  const auto u = [](const Point& p) { return std::sin(9 * p.x) + p.y * p.y; };
  std::vector<double> loads(2 * mesh.points.size(), 0);
  for (const auto& tet : mesh.tets) {
    double volume =
        six_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]) / 6;
    double sum = 0;
    for (const std::uint32_t v : tet) sum += u(mesh.points[v]);
    for (const std::uint32_t v : tet) {
      loads[2 * v] += volume / 20 * (sum + u(mesh.points[v]));
      loads[2 * v + 1] += volume / 4;  // of the constant 1
    }
  }
  std::vector<double> x(loads.size(), 0);
  MassMatrix(mesh).solve(loads, 2, x);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    EXPECT_NEAR(x[2 * v], u(mesh.points[v]), 1e-12);
    EXPECT_NEAR(x[2 * v + 1], 1, 1e-12);
  }
}

TEST(MassMatrix, LeavesVerticesWithoutTetsAlone) {
  MeshData mesh = support::two_tets();
  mesh.points.push_back({9, 9, 9});
  std::vector<double> x(mesh.points.size(), 7), b(mesh.points.size(), 0);
  MassMatrix(mesh).solve(b, 1, x);
  EXPECT_EQ(x.back(), 7);
  EXPECT_NEAR(x.front(), 0, 1e-11);
}

}  // namespace
}  // namespace weft::meshing::mass_matrix_test

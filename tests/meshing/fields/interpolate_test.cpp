// Tests of fields carried from mesh to mesh.
#include "meshing/fields/interpolate.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "meshing/base/error.h"
#include "tests/support/meshes.h"

namespace weft::meshing::interpolate_test {
namespace {

using support::unit_cube;

/// A scalar, a vector and a tensor field, all linear.
SolutionData linear_fields(const MeshData& mesh) {
  SolutionData solution{
      mesh.points.size(),
      {{Field::Kind::scalar, {}, "s"}, {Field::Kind::vector, {}, "v"}, {Field::Kind::tensor, {}, "t"}}};
  for (const Point& p : mesh.points)
    for (std::size_t f = 0; f < 3; ++f)
      for (int c = 0; c < components(solution.fields[f].kind); ++c)
        solution.fields[f].values.push_back(c + p.x - (c + 1) * p.y + 0.3 * p.z);
  return solution;
}

MeshData jittered(std::uint32_t n, unsigned seed) {
  MeshData mesh = unit_cube(n);
  support::jitter_interior(mesh, 0.2 / n, seed);
  support::shuffle(mesh, seed);
  return mesh;
}

TEST(Interpolate, IsExactForLinearFields) {
  const MeshData from = jittered(5, 1), to = jittered(7, 2);
  const Interpolation result = interpolate(from, linear_fields(from), to);
  const SolutionData exact = linear_fields(to);
  EXPECT_EQ(result.outside, 0);
  ASSERT_EQ(result.fields.fields.size(), 3);
  for (std::size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(result.fields.fields[f].name, exact.fields[f].name);
    ASSERT_EQ(result.fields.fields[f].values.size(), exact.fields[f].values.size());
    for (std::size_t i = 0; i < exact.fields[f].values.size(); ++i)
      EXPECT_NEAR(result.fields.fields[f].values[i], exact.fields[f].values[i], 1e-12);
  }
}

TEST(Interpolate, GivesTheSameMeshItsOwnValues) {
  const MeshData mesh = jittered(4, 3);
  SolutionData fields = linear_fields(mesh);
  for (double& v : fields.fields[0].values) v = std::sin(1e3 * v);
  const Interpolation result = interpolate(mesh, fields, mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    EXPECT_NEAR(result.fields.fields[0].values[i], fields.fields[0].values[i], 1e-9);
}

TEST(Interpolate, OutsideItTakesTheClosestValue) {
  const MeshData from = unit_cube(3);
  MeshData to;
  to.points = {{-1, 0.5, 0.5}, {2, 2, 2}, {0.5, 0.5, 0.5}};
  const Interpolation result = interpolate(from, linear_fields(from), to);
  EXPECT_EQ(result.outside, 2);
  EXPECT_NEAR(result.farthest, std::sqrt(3.0), 1e-12);
  const auto& s = result.fields.fields[0].values;
  EXPECT_NEAR(s[0], -0.5 + 0.15, 1e-12);
  EXPECT_NEAR(s[1], 0.3, 1e-12);
}

TEST(Interpolate, DoesNotDependOnTheThreads) {
  const MeshData from = jittered(9, 1), to = jittered(13, 2);
  const SolutionData fields = linear_fields(from);
  const Interpolation expected = interpolate(from, fields, to);
  for (const int threads : {1, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Interpolation result = interpolate(from, fields, to);
    for (std::size_t f = 0; f < 3; ++f)
      EXPECT_EQ(result.fields.fields[f].values, expected.fields.fields[f].values);
  }
}

TEST(Interpolate, RefusesAMeshWithoutVolume) {
  MeshData flat = unit_cube(2);
  std::swap(flat.tets[2][0], flat.tets[2][1]);
  EXPECT_THROW(interpolate(flat, linear_fields(flat), unit_cube(1)), InputError);
  EXPECT_THROW(interpolate({}, {}, unit_cube(1)), InputError);
}

TEST(Integrals, AreExactForLinearFields) {
  const MeshData mesh = jittered(4, 5);
  const SolutionData fields = linear_fields(mesh);
  EXPECT_NEAR(integrals(mesh, fields.fields[0])[0], 0.15, 1e-12);
  EXPECT_NEAR(integrals(mesh, fields.fields[1])[2], 2 + 0.5 - 1.5 + 0.15, 1e-12);
}

}  // namespace
}  // namespace weft::meshing::interpolate_test

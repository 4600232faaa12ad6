// Tests of the metric that a mesh implies.
#include "meshing/metric/sources/implied_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshing/base/error.h"
#include "meshing/metric/measures.h"
#include "tests/support/meshes.h"

namespace weft::meshing::implied_metric_test {
namespace {

TEST(ImpliedMetric, MakesTheEdgesOfOneTetUnit) {
  for (const MeshData& mesh :
       {support::regular_tet(0.3),
        support::mesh_of({{0, 0, 0}, {1, 0.1, 0}, {0.3, 0.02, 0.01}, {0.5, -0.2, 3}}, {{0, 1, 2, 3}})}) {
    MeshData upright = mesh;
    const auto& p = upright.points;
    if (six_volume(p[0], p[1], p[2], p[3]) < 0) std::swap(upright.tets[0][2], upright.tets[0][3]);
    for (const LogMetric& l : implied_metric(upright))
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j) EXPECT_NEAR(squared_length(exp_exact(l), p[j] - p[i]), 1, 1e-9);
  }
}

TEST(ImpliedMetric, HasTheComplexityOfTheMesh) {
  // All tets of a box are of one volume, and a unit tet has sqrt(2)/12 of complexity.
  const MeshData mesh = support::unit_cube(5);
  EXPECT_NEAR(complexity(mesh, implied_metric(mesh)),
              static_cast<double>(mesh.tets.size()) * std::numbers::sqrt2 / 12, 1e-9);
}

TEST(ImpliedMetric, RefusesTetsWithoutVolume) {
  MeshData mesh = support::unit_cube(2);
  std::swap(mesh.tets[6][0], mesh.tets[6][1]);
  try {
    implied_metric(mesh);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "tet 7: has no volume or is inverted, so no metric");
  }
}

TEST(ImpliedMetric, GivesAVertexOfNoTetTheLargestSize) {
  MeshData mesh = support::unit_cube(2);
  mesh.points.push_back({0.5, 0.5, 0.5});
  mesh.point_refs.push_back(0);
  EXPECT_NEAR(std::exp(-0.5 * implied_metric(mesh).back().xx), std::sqrt(3.0), 1e-12);
}

}  // namespace
}  // namespace weft::meshing::implied_metric_test

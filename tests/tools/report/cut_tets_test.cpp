// Each plane's tets are those of which a look at every tet says so.
#include "tools/report/cut_tets.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

#include "meshing/mesh/structured_box.h"
#include "tools/picture/shown_faces.h"

namespace weft::report::cut_tets_test {
namespace {

using meshing::MeshData;

/// More tets than one task looks at.
MeshData shaken_box() {
  MeshData mesh = meshing::structured_box({.cells = {18, 17, 16}, .min = {0, 0, 0}, .max = {1, 2, 3}});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.01, 0.01);
  for (std::size_t p = 0; p < mesh.points.size(); p += 2)
    for (int a = 0; a < 3; ++a) mesh.points[p][a] += shift(random);
  return mesh;
}

void check(const MeshData& mesh, const AxisPlanes& planes) {
  const std::vector<std::vector<std::uint32_t>> cut = cut_tets(mesh, planes);
  std::size_t list = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double position : planes[static_cast<std::size_t>(axis)]) {
      picture::Plane plane{{0, 0, 0}, position};
      plane.normal[axis] = 1;
      std::vector<std::uint32_t> expected;
      for (const picture::Section& section : picture::sections(mesh, plane)) expected.push_back(section.tet);
      ASSERT_LT(list, cut.size());
      EXPECT_EQ(cut[list++], expected);
    }
  EXPECT_EQ(list, cut.size());
}

TEST(CutTets, AreThoseWithVerticesOnBothSides) {
  check(shaken_box(), {{{0.1, 0.33, 0.34, 0.9}, {1.01}, {0.2, 1.7, 2.999}}});
}

/// Also where planes pass through vertices, contain faces, miss the mesh or are the same.
TEST(CutTets, AreThoseOfPlanesThroughVertices) {
  const MeshData mesh = meshing::structured_box({.cells = {4, 4, 4}, .min = {0, 0, 0}, .max = {1, 1, 1}});
  check(mesh, {{{0, 0.25, 0.5, 0.5, 1}, {}, {-1, 0.75, 2}}});
}

TEST(CutTets, AreNoneWithoutPlanesOrTets) {
  EXPECT_TRUE(cut_tets(shaken_box(), {}).empty());
  check({}, {{{0.5}, {}, {}}});
}

TEST(CutTets, DoNotDependOnThreads) {
  const MeshData mesh = shaken_box();
  const AxisPlanes planes = {{{0.1, 0.5}, {0.7, 1.3}, {1}}};
  const auto expected = cut_tets(mesh, planes);
  for (const std::size_t threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(cut_tets(mesh, planes), expected);
  }
}

}  // namespace
}  // namespace weft::report::cut_tets_test

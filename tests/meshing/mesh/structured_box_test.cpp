// The structured box: conforming, right volumes and references, no tet stuck in a corner.
#include "meshing/mesh/structured_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/mesh/check_mesh.h"

namespace weft::meshing::structured_box_test {
namespace {

/// How many of each tet's faces lie on the boundary: index = tet.
std::vector<int> boundary_faces_of_tets(const MeshData& mesh) {
  std::vector<int> faces(mesh.tets.size());
  for (const auto& triangle : mesh.triangles)
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const auto in_tet = [&](std::uint32_t v) {
        return std::ranges::find(mesh.tets[t], v) != mesh.tets[t].end();
      };
      faces[t] += std::ranges::all_of(triangle, in_tet);
    }
  return faces;
}

TEST(StructuredBox, ConformsForEvenAndOddNumbersOfCells) {
  for (const std::array<std::uint32_t, 3> cells :
       {std::array<std::uint32_t, 3>{1, 1, 1}, {2, 2, 2}, {3, 1, 2}, {5, 4, 3}}) {
    const MeshData mesh = structured_box({cells, {-1, 0, 2}, {1, 3, 2.5}});
    const CheckReport report = check_mesh(mesh);
    EXPECT_TRUE(report.ok()) << report.problems.front();
    EXPECT_EQ(report.num_components, 1u);
    EXPECT_NEAR(report.volume, 3, 1e-12);
    EXPECT_EQ(mesh.tets.size(), 6u * cells[0] * cells[1] * cells[2]);
  }
}

TEST(StructuredBox, FacesHaveTheDocumentedReferencesAndAreas) {
  const CheckReport report = check_mesh(structured_box({{3, 4, 5}, {0, 0, 0}, {1, 2, 4}}));
  ASSERT_EQ(report.area_by_ref.size(), 6u);
  for (const int x : {1, 2}) EXPECT_NEAR(report.area_by_ref.at(x), 8, 1e-12);
  for (const int y : {3, 4}) EXPECT_NEAR(report.area_by_ref.at(y), 4, 1e-12);
  for (const int z : {5, 6}) EXPECT_NEAR(report.area_by_ref.at(z), 2, 1e-12);
  const MeshData mesh = structured_box({{2, 2, 2}, {0, 0, 0}, {1, 1, 1}});
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const int axis = (mesh.triangle_refs[i] - 1) / 2;
    const double side = (mesh.triangle_refs[i] - 1) % 2;
    for (const std::uint32_t v : mesh.triangles[i]) EXPECT_EQ(mesh.points[v][axis], side);
  }
}

TEST(StructuredBox, TrianglesFaceOutwards) {
  const MeshData mesh = structured_box({{3, 2, 2}, {0, 0, 0}, {1, 1, 1}});
  const Point centre = {0.5, 0.5, 0.5};
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
    EXPECT_GT(dot(cross(q - p, r - p), p - centre), 0);
  }
}

TEST(StructuredBox, TwelveEdgesAreRidgesAndEightVerticesCorners) {
  const MeshData mesh = structured_box({{2, 3, 4}, {0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(mesh.corners.size(), 8u);
  EXPECT_EQ(mesh.edges.size(), 4u * (2 + 3 + 4));
  EXPECT_EQ(mesh.ridges.size(), mesh.edges.size());
  EXPECT_EQ(*std::ranges::max_element(mesh.edge_refs), 12);
  for (const auto& [a, b] : mesh.edges) {
    int on_faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double x = mesh.points[a][axis];
      on_faces += x == mesh.points[b][axis] && (x == 0 || x == 1);
    }
    EXPECT_EQ(on_faces, 2);
  }
}

TEST(StructuredBox, NoTetHasTwoBoundaryFaces) {
  for (const std::array<std::uint32_t, 3> cells : {std::array<std::uint32_t, 3>{2, 2, 2}, {3, 2, 5}}) {
    const std::vector<int> faces = boundary_faces_of_tets(structured_box({cells, {0, 0, 0}, {1, 1, 1}}));
    EXPECT_LE(*std::ranges::max_element(faces), 1);
  }
}

TEST(StructuredBox, RefusesABoxThatIsNone) {
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_THROW(structured_box({{0, 1, 1}, {0, 0, 0}, {1, 1, 1}}), InputError);
  EXPECT_THROW(structured_box({{1, 1, 1}, {0, 0, 0}, {1, 0, 1}}), InputError);
  EXPECT_THROW(structured_box({{1, 1, 1}, {0, 0, 0}, {1, infinite, 1}}), InputError);
  EXPECT_THROW(structured_box({{100000, 100000, 1}, {0, 0, 0}, {1, 1, 1}}), InputError);
}

}  // namespace
}  // namespace weft::meshing::structured_box_test

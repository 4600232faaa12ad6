// Complete is what import_mesh() has nothing to say about.
#include "meshing/kernel/complete.h"

#include <gtest/gtest.h>

#include <functional>

#include "meshing/kernel/import_mesh.h"
#include "tests/partition/metric_meshes.h"
#include "tests/support/meshes.h"

namespace weft::meshing::complete_test {
namespace {

bool has_warnings(const MeshData& mesh) {
  return !import_mesh(mesh, kRidgeAngle, mesh.points.size() + 1, mesh.tets.size() + 1).warnings.empty();
}

TEST(IsComplete, WhereImportHasNothingToComplete) {
  int complete = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    const MeshData mesh = support::random_metric_mesh(seed).mesh;
    EXPECT_EQ(is_complete(mesh), !has_warnings(mesh)) << seed;
    complete += is_complete(mesh);
  }
  EXPECT_GT(complete, 3);
  EXPECT_LT(complete, 21);
}

TEST(IsComplete, FindsWhatIsMissingOrTooMuch) {
  const MeshData sound = support::layered_box(3, 2, 3);
  ASSERT_TRUE(is_complete(sound));
  const auto after = [&](const std::function<void(MeshData&)>& change) {
    MeshData mesh = sound;
    change(mesh);
    return is_complete(mesh);
  };
  EXPECT_FALSE(after([](MeshData& m) { m.triangles.pop_back(), m.triangle_refs.pop_back(); }));
  EXPECT_FALSE(
      after([](MeshData& m) { m.triangles.push_back(m.triangles[0]), m.triangle_refs.push_back(1); }));
  EXPECT_FALSE(after([](MeshData& m) { m.points.push_back({9, 9, 9}), m.point_refs.push_back(0); }));
  EXPECT_FALSE(after([](MeshData& m) { m.tet_refs[5] += 100; }));
  EXPECT_FALSE(after([](MeshData& m) { std::swap(m.tets[5][0], m.tets[5][1]); }));
  EXPECT_FALSE(after([](MeshData& m) { m.association.nodes.push_back({0, 1}); }));
  const auto edge_of = [](const MeshData& m) { return std::array{m.triangles[0][1], m.triangles[0][0]}; };
  const auto add_edge = [](MeshData& m, const std::array<std::uint32_t, 2>& edge) {
    m.edges.push_back(edge);
    m.edge_refs.push_back(1);
  };
  MeshData one_edge = sound;
  one_edge.edges.clear(), one_edge.edge_refs.clear(), one_edge.ridges.clear();
  add_edge(one_edge, edge_of(one_edge));
  EXPECT_TRUE(is_complete(one_edge));
  add_edge(one_edge, {one_edge.edges[0][1], one_edge.edges[0][0]});  // again
  EXPECT_FALSE(is_complete(one_edge));
  EXPECT_FALSE(after([&](MeshData& m) {
    for (const auto& tet : m.tets)  // an edge inside, in the middle of the box
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const Point middle = 0.5 * (m.points[tet[i]] + m.points[tet[j]]);
          if (norm(middle - Point{0.5, 0.5, 1}) < 0.2) return add_edge(m, {tet[i], tet[j]});
        }
  }));
}

TEST(IsComplete, NotWhereTheMeshTouchesItself) {
  const std::array<std::uint32_t, 2> edge{3, 7};
  std::vector<TriangleSide> sides(4, {edge, 1});
  EXPECT_FALSE(edges_are_complete(sides, {}));
  for (std::size_t i = 2; i < 4; ++i) sides[i].outer = 0;  // an interface that ends at the boundary
  EXPECT_TRUE(edges_are_complete(sides, {edge}));
  EXPECT_FALSE(edges_are_complete(sides, {edge, edge}));
  EXPECT_FALSE(edges_are_complete(sides, {{2, 7}}));
  EXPECT_FALSE(edges_are_complete(sides, {edge, {8, 9}}));
}

}  // namespace
}  // namespace weft::meshing::complete_test

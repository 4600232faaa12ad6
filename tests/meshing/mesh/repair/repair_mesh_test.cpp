// Marks of what is mended; the mends themselves are tested through the command (tests/tools/repair_test.py).
#include "meshing/mesh/repair/repair_mesh.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "meshing/mesh/structured_box.h"

namespace weft::meshing::repair_mesh_test {
namespace {

using List = std::vector<std::uint32_t>;

TEST(RepairMesh, WhatIsThereTwiceKeepsTheMarksOfBoth) {
  MeshData mesh = structured_box({{2, 2, 2}, {0, 0, 0}, {1, 1, 1}});
  const std::size_t edges = mesh.edges.size(), triangles = mesh.triangles.size();
  const auto [a, b] = mesh.edges[3];
  mesh.edges.push_back({b, a});
  mesh.edge_refs.push_back(mesh.edge_refs[3]);
  mesh.ridges = mesh.required_edges = {static_cast<std::uint32_t>(edges)};
  mesh.triangles.push_back(mesh.triangles[5]);
  mesh.triangle_refs.push_back(mesh.triangle_refs[5]);
  mesh.required_triangles = {static_cast<std::uint32_t>(triangles)};
  repair_mesh(mesh);
  EXPECT_EQ(mesh.edges.size(), edges);
  EXPECT_EQ(mesh.triangles.size(), triangles);
  EXPECT_EQ(mesh.ridges, List{3});
  EXPECT_EQ(mesh.required_edges, List{3});
  EXPECT_EQ(mesh.required_triangles, List{5});
}

}  // namespace
}  // namespace weft::meshing::repair_mesh_test

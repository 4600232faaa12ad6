// The completed boundary in shares is that of the whole mesh.
#include "partition/surface/boundary_share.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <random>

#include "meshing/mesh/boundary_entities.h"
#include "meshing/mesh/touching_edges.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::partition::boundary_share_test {
namespace {

using meshing::MeshData;

struct Known {
  std::int32_t ref;
  bool required;
  friend bool operator==(const Known&, const Known&) = default;
};
using Edges = std::map<std::array<std::uint32_t, 2>, Known>;

/// Edges as lists that are read one after the other leave them.
Edges edges_of(const MeshData& boundary) {
  Edges edges;
  const auto take = [&](std::uint32_t e, bool required) {
    const auto [a, b] = std::minmax(boundary.edges[e][0], boundary.edges[e][1]);
    edges[{a, b}] = {boundary.edge_refs[e], required};
  };
  for (std::uint32_t e = 0; e < boundary.edges.size(); ++e) take(e, false);
  for (const std::uint32_t e : boundary.required_edges) take(e, true);
  return edges;
}

/// Cells that touch at edges, with edges listed and required, once or more, in any direction, and some
/// inside.
MeshData mesh_with_edges(unsigned seed) {
  MeshData mesh = support::touching_cells(4, seed);
  std::mt19937 random(seed);
  const auto list = [&](std::uint32_t a, std::uint32_t b) {
    if (random() % 3 == 0) mesh.required_edges.push_back(static_cast<std::uint32_t>(mesh.edges.size()));
    mesh.edges.push_back({a, b});
    mesh.edge_refs.push_back(static_cast<std::int32_t>(random() % 100));
  };
  for (int i = 0; i < 200; ++i) {
    const auto& v = mesh.triangles[random() % mesh.triangles.size()];
    list(v[0], v[1]);
    if (random() % 2) list(v[1], v[0]);
  }
  for (int i = 0; i < 5; ++i) {
    const auto& v = mesh.tets[random() % mesh.tets.size()];
    list(v[0], v[2]);
  }
  std::ranges::shuffle(mesh.required_edges, random);
  mesh.required_triangles = {0, static_cast<std::uint32_t>(mesh.triangles.size()) - 1};
  mesh.corners.clear();
  for (unsigned i = 0; i < 10 * (seed % 2); ++i) {  // some in both lists, some twice in one
    mesh.corners.push_back(mesh.triangles[random() % mesh.triangles.size()][i % 3]);
    mesh.required_points.push_back(i % 3 ? mesh.corners[random() % mesh.corners.size()] : mesh.tets[i][0]);
  }
  return mesh;
}

TEST(BoundaryShare, HasEachTriangleAndEdgeOnceAsTheListsLeaveIt) {
  std::size_t touching_edges = 0;
  for (unsigned seed = 0; seed < 4; ++seed)
    for (const int ranks : support::kNumbersOfRanks) {
      SCOPED_TRACE(ranks);
      const support::MetricMesh whole{mesh_with_edges(seed), meshing::LogMetricField(1000)};
      MeshData expected;
      expected.triangles = whole.mesh.triangles;
      std::vector<std::string> warnings;
      meshing::take_boundary_edges(whole.mesh, expected, warnings);
      touching_edges += meshing::require_touching_edges(whole.mesh.triangles, expected);
      std::mutex mutex;
      std::map<std::uint32_t, BoundaryTriangle> triangles;
      std::map<std::uint32_t, std::uint32_t> points, expected_points;  // vertices and flags
      for (const std::uint32_t v : whole.mesh.corners) expected_points[v] |= meshing::kListedCorner;
      for (const std::uint32_t v : whole.mesh.required_points) expected_points[v] |= meshing::kListedRequired;
      Edges edges;
      support::run_ranks(ranks, [&](Peers& peers) {
        MeshSlice slice = support::slice_of(whole, peers.rank(), ranks, seed);
        const Ranges of_points(peers, slice.points.size()), tets(peers, slice.tets.size());
        const BoundaryShare share = complete_boundary(peers, slice, placed(slice.tets), of_points, tets);
        EXPECT_TRUE(slice.boundary.triangles.empty());
        const std::lock_guard lock(mutex);
        for (const BoundaryTriangle& t : share.triangles) EXPECT_TRUE(triangles.emplace(t.number, t).second);
        for (const BoundaryEdge& e : share.edges) {
          EXPECT_EQ(e.vertices[0] % static_cast<std::uint32_t>(ranks),
                    static_cast<std::uint32_t>(peers.rank()));
          EXPECT_TRUE(edges.emplace(e.vertices, Known{e.ref, e.required != 0}).second);
        }
        EXPECT_EQ(share.any_listed_points, !expected_points.empty());
        EXPECT_TRUE(std::ranges::is_sorted(share.listed_points, {}, &ListedPoint::vertex));
        for (const auto& [v, flags] : share.listed_points) {
          EXPECT_EQ(v % static_cast<std::uint32_t>(ranks), static_cast<std::uint32_t>(peers.rank()));
          EXPECT_TRUE(points.emplace(v, flags).second);
        }
        if (ranks == 8) {
          EXPECT_LT(share.triangles.size(), whole.mesh.triangles.size() / 3);
        }
      });
      ASSERT_EQ(triangles.size(), whole.mesh.triangles.size());
      for (const auto& [number, t] : triangles) {
        EXPECT_EQ(t.vertices, whole.mesh.triangles[number]);
        EXPECT_EQ(t.ref, whole.mesh.triangle_refs[number]);
        EXPECT_EQ(t.required != 0, std::ranges::count(whole.mesh.required_triangles, number) > 0);
      }
      EXPECT_EQ(edges, edges_of(expected));
      EXPECT_EQ(points, expected_points);
    }
  EXPECT_GT(touching_edges, 0u);
}

}  // namespace
}  // namespace weft::partition::boundary_share_test

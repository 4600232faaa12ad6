// After a mesh is read in shares no rank has more than its own, and together they are the whole.
#include "tools/library/jobs/sources/shares.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "meshing/io/mesh_file.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::tools::shares_test {
namespace {

using meshing::MeshContents;
using meshing::MeshData;
using partition::MeshSlice;
using partition::Peers;

MeshContents marked_box() {
  MeshContents box;
  box.mesh = meshing::structured_box({{6, 5, 4}, {0, 0, 0}, {6, 5, 4}});
  for (std::uint32_t t = 0; t < box.mesh.triangles.size(); t += 2) box.mesh.required_triangles.push_back(t);
  for (std::uint32_t e = 0; e < box.mesh.edges.size(); e += 3) box.mesh.required_edges.push_back(e);
  box.mesh.ridges.clear();
  for (std::uint32_t e = 0; e < box.mesh.edges.size(); ++e) box.mesh.ridges.push_back(e);
  box.mesh.required_points = {3, 11};
  box.complete();
  return box;
}

template <class T>
void expect_joined(const std::vector<std::vector<T>>& shares, const std::vector<T>& whole) {
  std::vector<T> joined;
  for (const auto& share : shares) joined.insert(joined.end(), share.begin(), share.end());
  EXPECT_EQ(joined, whole);
}

template <class T>
void expect_shares(const std::vector<std::vector<T>>& shares, const std::vector<T>& whole) {
  for (const auto& share : shares) EXPECT_LE(share.size(), whole.size() / shares.size() + 1);
  expect_joined(shares, whole);
}

struct Shares {
  explicit Shares(std::size_t ranks)
      : triangles(ranks),
        edges(ranks),
        refs(ranks),
        ridges(ranks),
        edge_marks(ranks),
        triangle_marks(ranks),
        corners(ranks),
        point_marks(ranks) {}
  std::vector<std::vector<std::array<std::uint32_t, 3>>> triangles;
  std::vector<std::vector<std::array<std::uint32_t, 2>>> edges;
  std::vector<std::vector<std::int32_t>> refs;
  std::vector<std::vector<std::uint32_t>> ridges, edge_marks, triangle_marks, corners, point_marks;

  void take(std::size_t r, const MeshData& b) {
    triangles[r] = b.triangles, edges[r] = b.edges, refs[r] = b.triangle_refs;
    corners[r] = b.corners, point_marks[r] = b.required_points;
    ridges[r] = b.ridges, edge_marks[r] = b.required_edges, triangle_marks[r] = b.required_triangles;
  }
};

class MeshShares : public testing::TestWithParam<std::string> {
 protected:
  meshing::TemporaryDirectory directory;
};

TEST_P(MeshShares, OfTheBoundaryAreEven) {
  constexpr int kRanks = 4;
  const auto file = directory / GetParam();
  meshing::write_mesh_contents(file, marked_box());
  const MeshData whole = meshing::read_mesh(file);
  Shares shares(kRanks);
  support::run_ranks(kRanks, [&](Peers& peers) {
    const MeshSlice slice = read_mesh_share(peers, file.string()).slice;
    const auto r = static_cast<std::size_t>(peers.rank());
    EXPECT_EQ(slice.num_triangles, whole.triangles.size());
    EXPECT_EQ(slice.num_edges, whole.edges.size());
    EXPECT_EQ(slice.first_triangle, whole.triangles.size() * r / kRanks);
    EXPECT_EQ(slice.first_edge, whole.edges.size() * r / kRanks);
    shares.take(r, slice.boundary);
  });
  expect_shares(shares.triangles, whole.triangles);
  expect_shares(shares.refs, whole.triangle_refs);
  expect_shares(shares.edges, whole.edges);
  expect_shares(shares.ridges, whole.ridges);
  expect_shares(shares.edge_marks, whole.required_edges);
  expect_shares(shares.triangle_marks, whole.required_triangles);
  expect_joined(shares.corners, whole.corners);
  expect_joined(shares.point_marks, whole.required_points);
  for (const auto& share : shares.corners)
    EXPECT_TRUE(whole.corners.empty() || share.size() < whole.corners.size());
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshShares,
                         testing::Values("m.meshb", "m.mesh", "m.lb8.ugrid", "m.ugrid", "m.cgns", "m.vtu",
                                         "m.msh", "m.su2", "m.pvtu"));

TEST(MeshShare, OfCgnsWithMixedElementsIsReadByEachRank) {
  constexpr int kRanks = 4;
  const std::string file = meshing::sample("cgns-mixed.cgns").string();
  meshing::RefNames names;
  const MeshData whole = meshing::read_mesh(file, &names);
  std::vector<std::vector<meshing::Point>> points(kRanks);
  std::vector<std::vector<std::array<std::uint32_t, 4>>> tets(kRanks);
  std::vector<std::vector<std::int32_t>> tet_refs(kRanks);
  Shares shares(kRanks);
  support::run_ranks(kRanks, [&](Peers& peers) {
    const MeshShare share = read_mesh_share(peers, file);
    const auto r = static_cast<std::size_t>(peers.rank());
    EXPECT_FALSE(share.read_whole);
    EXPECT_EQ(share.names.all(), names.all());
    points[r] = share.slice.points, tets[r] = share.slice.tets, tet_refs[r] = share.slice.tet_refs;
    shares.take(r, share.slice.boundary);
  });
  expect_shares(points, whole.points);
  expect_shares(tets, whole.tets);
  expect_shares(tet_refs, whole.tet_refs);
  expect_shares(shares.triangles, whole.triangles);
  expect_shares(shares.refs, whole.triangle_refs);
  expect_shares(shares.edges, whole.edges);
}

}  // namespace
}  // namespace weft::tools::shares_test

// A mesh that fits its metric comes out as it went in, on any ranks and in any shares.
#include "partition/fit/as_given.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <mutex>
#include <optional>
#include <random>

#include "meshing/metric/measures.h"
#include "partition/fields/slice_piece.h"
#include "partition/fit/fit_in_parts.h"
#include "partition/output/merge_pieces.h"
#include "partition/verify/check_pieces.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/fitting_mesh.h"

namespace weft::partition::as_given_test {
namespace {

using meshing::MeshData;
using support::fitting_mesh;
using support::MetricMesh;

/// The pieces of all ranks; empty where there is nothing given, on every rank.
std::optional<MergedMesh> merged_on(int ranks, const MetricMesh& whole, unsigned seed, double target = 0) {
  std::vector<MeshPiece> pieces;
  int none = 0;
  std::mutex lock;
  support::run_ranks(ranks, [&](Peers& peers) {
    auto given = as_given(peers, support::slice_of(whole, peers.rank(), ranks, seed), target);
    if (given) {
      EXPECT_TRUE(check_pieces(peers, {&given->piece, 1}).ok());
    }
    const std::scoped_lock hold(lock);
    given ? pieces.push_back(std::move(given->piece)) : void(++none);
  });
  EXPECT_TRUE(none == 0 || none == ranks);
  if (none > 0) return {};
  return merge_pieces(pieces);
}

void expect_same(const MeshData& mesh, const MeshData& other) {
  EXPECT_EQ(mesh.points, other.points);
  EXPECT_EQ(mesh.point_refs, other.point_refs);
  EXPECT_EQ(mesh.tets, other.tets);
  EXPECT_EQ(mesh.tet_refs, other.tet_refs);
  EXPECT_EQ(mesh.triangles, other.triangles);
  EXPECT_EQ(mesh.triangle_refs, other.triangle_refs);
  EXPECT_EQ(mesh.edges, other.edges);
  EXPECT_EQ(mesh.edge_refs, other.edge_refs);
  EXPECT_EQ(mesh.corners, other.corners);
  EXPECT_EQ(mesh.ridges, other.ridges);
  EXPECT_EQ(mesh.required_points, other.required_points);
  EXPECT_EQ(mesh.required_edges, other.required_edges);
  EXPECT_EQ(mesh.required_triangles, other.required_triangles);
}

MetricMesh with_required_entities() {
  MetricMesh m = fitting_mesh();
  for (std::uint32_t v = 0; v < m.mesh.points.size(); ++v)
    m.mesh.point_refs[v] = static_cast<std::int32_t>(v % 7);
  for (std::uint32_t v = 3; v < m.mesh.points.size(); v += 50) m.mesh.required_points.push_back(v);
  for (std::uint32_t t = 3; t < m.mesh.triangles.size(); t += 50) m.mesh.required_triangles.push_back(t);
  for (std::uint32_t e = 3; e < m.mesh.edges.size(); e += 5) m.mesh.required_edges.push_back(e);
  return m;
}

TEST(AsGiven, AMeshThatFitsIsTheResult) {
  const MetricMesh m = with_required_entities();
  ASSERT_FALSE(m.mesh.ridges.empty());
  for (const int ranks : {1, 2, 3, 5})
    for (const unsigned seed : {0u, 1u, 2u}) {
      const auto merged = merged_on(ranks, m, seed);
      ASSERT_TRUE(merged) << ranks << " ranks, shares " << seed;
      expect_same(merged->mesh, m.mesh);
      EXPECT_EQ(merged->log_metrics, m.log_metrics);
    }
}

TEST(AsGiven, TrianglesComeInTheOrderOfTheirTets) {
  MetricMesh m = with_required_entities();
  const std::vector<meshing::Triangle> triangles = m.mesh.triangles;
  m.mesh.required_triangles.clear();
  std::ranges::reverse(m.mesh.triangles);
  std::ranges::reverse(m.mesh.triangle_refs);
  for (const int ranks : {1, 4}) {
    const auto merged = merged_on(ranks, m, 3);
    ASSERT_TRUE(merged);
    EXPECT_EQ(merged->mesh.triangles, triangles);
  }
}

TEST(AsGiven, TheMetricIsScaled) {
  const MetricMesh& m = fitting_mesh();
  const double complexity = meshing::complexity(m.mesh, m.log_metrics);
  std::vector<meshing::LogMetricField> scaled;
  for (const int ranks : {1, 3}) {
    const auto merged = merged_on(ranks, m, 0, 1.01 * complexity);
    ASSERT_TRUE(merged);
    EXPECT_NEAR(meshing::complexity(merged->mesh, merged->log_metrics), 1.01 * complexity, 1e-9 * complexity);
    scaled.push_back(merged->log_metrics);
    EXPECT_FALSE(merged_on(ranks, m, 0, 1.2 * complexity));
  }
  EXPECT_EQ(scaled[0], scaled[1]);
}

TEST(AsGiven, NotWhereTheMetricIsOffInAPart) {
  MetricMesh m = fitting_mesh();
  for (std::size_t v = 0; v < m.mesh.points.size(); ++v)
    if (m.mesh.points[v].z < 0.6) m.log_metrics[v] = support::times(1.05, m.log_metrics[v]);
  for (const int ranks : {1, 2, 3, 5}) EXPECT_FALSE(merged_on(ranks, m, 1));
}

TEST(AsGiven, NotWhereSomethingIsToBeCompleted) {
  const auto refused = [](const std::function<void(MeshData&)>& change) {
    MetricMesh m = fitting_mesh();
    change(m.mesh);
    m.log_metrics.resize(m.mesh.points.size(), m.log_metrics[0]);
    for (const int ranks : {1, 2, 5})
      if (merged_on(ranks, m, static_cast<unsigned>(ranks))) return false;
    return true;
  };
  EXPECT_FALSE(refused([](MeshData&) {}));
  EXPECT_TRUE(refused([](MeshData& m) { m.triangles.pop_back(), m.triangle_refs.pop_back(); }));
  EXPECT_TRUE(
      refused([](MeshData& m) { m.triangles.push_back(m.triangles[9]), m.triangle_refs.push_back(1); }));
  EXPECT_TRUE(refused([](MeshData& m) { m.points.push_back({9, 9, 9}), m.point_refs.push_back(0); }));
  EXPECT_TRUE(refused([](MeshData& m) { m.edges.push_back(m.edges[3]), m.edge_refs.push_back(1); }));
  EXPECT_TRUE(refused([](MeshData& m) { m.tet_refs[m.tet_refs.size() / 2] = 77; }));
  EXPECT_TRUE(refused([](MeshData& m) { m.association.nodes.push_back({0, 1}); }));
  EXPECT_TRUE(refused([](MeshData& m) { std::ranges::shuffle(m.tets, std::mt19937(1)); }));
}

TEST(FitInParts, IsThatOfTheWholeMesh) {
  const MetricMesh& m = fitting_mesh();
  const auto whole = meshing::fit_of(m.mesh, m.log_metrics);
  ASSERT_TRUE(whole);
  for (const int ranks : {1, 2, 3, 5})
    support::run_ranks(ranks, [&](Peers& peers) {
      const MeshSlice slice = support::slice_of(m, peers.rank(), ranks, static_cast<unsigned>(ranks));
      const auto fit = fit_in_parts(peers, piece_of_slice(peers, slice).piece);
      ASSERT_TRUE(fit);
      EXPECT_EQ(fit->edges_long, whole->edges_long);
      EXPECT_EQ(fit->edges_short, whole->edges_short);
      EXPECT_EQ(fit->quality_mean, whole->quality_mean);
      EXPECT_EQ(fit->tets_of_complexity, whole->tets_of_complexity);
    });
}

}  // namespace
}  // namespace weft::partition::as_given_test

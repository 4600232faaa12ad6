// A surface built in shares is the whole one, whatever is cut by the shares' borders.
#include "partition/surface/surface_shares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "meshing/geometry/model/analytic_model.h"
#include "meshing/geometry/model/model.h"
#include "meshing/geometry/surface/surface.h"
#include "partition/surface/joined_patches.h"
#include "partition/surface/surface_parts.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/support/meshes.h"
#include "tests/support/repetitions.h"

namespace weft::partition::surface_shares_test {
namespace {

using meshing::MeshData;
using meshing::Point;
using meshing::Surface;

/// Some thousand triangles without tets: bodies of curved patches, planes and curves, in no order.
MeshData body(unsigned seed) {
  MeshData mesh = seed % 2 ? support::cylinder(60, 1, 30, 2) : support::ball(4, 1);
  for (Point& p : mesh.points)
    if (seed % 2 == 0) p = (1 + 0.05 * std::sin(7 * p.x + seed) * std::cos(5 * p.y)) * p;
  support::shuffle(mesh, seed);
  mesh.tets.clear();
  mesh.tet_refs.clear();
  return mesh;
}

/// References, lists of all kinds, and triangles seen from within, all across the mesh.
void add_features(MeshData& mesh, unsigned seed) {
  std::mt19937 random(seed);
  const auto one_in = [&](unsigned n) { return random() % n == 0; };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    auto& v = mesh.triangles[t];
    mesh.triangle_refs[t] = mesh.points[v[0]].x > 0.3 ? 7 : mesh.points[v[0]].y > 0.5 ? 8 : 3;
    if (one_in(3)) std::swap(v[0], v[2]);
    if (one_in(200)) mesh.required_triangles.push_back(t);
    if (one_in(20)) {
      if (one_in(3)) mesh.required_edges.push_back(static_cast<std::uint32_t>(mesh.edges.size()));
      mesh.edges.push_back({v[1], v[0]});
      mesh.edge_refs.push_back(static_cast<std::int32_t>(random() % 3));
    }
    if (one_in(300)) mesh.corners.push_back(v[0]);
    if (one_in(300)) mesh.required_points.push_back(v[1]);
  }
  mesh.corners.push_back(static_cast<std::uint32_t>(mesh.points.size()));
  mesh.points.push_back({9, 9, 9});  // of no triangle
  mesh.point_refs.push_back(0);
}

/// Triangles without area, alone and several in a row.
void flatten(MeshData& mesh, unsigned seed) {
  std::mt19937 random(seed);
  for (int i = 0; i < 60; ++i) {
    const auto& [a, b, c] = mesh.triangles[random() % mesh.triangles.size()];
    mesh.points[c] = midpoint(mesh.points[a], mesh.points[b]);
  }
}

void add_moebius_strip(MeshData& mesh) {
  constexpr std::uint32_t kSteps = 40;
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (std::uint32_t i = 0; i < kSteps; ++i)
    for (const double side : {-0.2, 0.2}) {
      const double angle = 2 * std::numbers::pi * i / kSteps, out = 1 + side * std::cos(angle / 2);
      mesh.points.push_back({5 + out * std::cos(angle), out * std::sin(angle), side * std::sin(angle / 2)});
      mesh.point_refs.push_back(0);
    }
  const auto at = [&](std::uint32_t i, std::uint32_t side) {
    return first + 2 * (i % kSteps) + (i < kSteps ? side : 1 - side);
  };
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    mesh.triangles.push_back({at(i, 0), at(i + 1, 0), at(i, 1)});
    mesh.triangles.push_back({at(i + 1, 0), at(i + 1, 1), at(i, 1)});
  }
  mesh.triangle_refs.resize(mesh.triangles.size(), 3);
}

/// As a rank may have it of a completed boundary: some of the triangles in any order, its edges, and lists.
BoundaryShare share_of(const MeshData& mesh, const Peers& peers) {
  const auto ranks = static_cast<std::uint32_t>(peers.ranks()), me = static_cast<std::uint32_t>(peers.rank());
  BoundaryShare share;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if ((t * 2654435761u >> 8) % ranks == me)
      share.triangles.push_back(
          {t, mesh.triangles[t], mesh.triangle_refs[t], std::ranges::count(mesh.required_triangles, t) > 0});
  std::ranges::reverse(share.triangles);
  std::map<std::array<std::uint32_t, 2>, BoundaryEdge> edges;
  const auto add = [&](std::uint32_t e, std::uint32_t required) {
    const auto [a, b] = std::minmax(mesh.edges[e][0], mesh.edges[e][1]);
    edges[{a, b}] = {{a, b}, mesh.edge_refs[e], required};
  };
  for (std::uint32_t e = 0; e < mesh.edges.size(); ++e) add(e, 0);
  for (const std::uint32_t e : mesh.required_edges) add(e, 1);
  for (const auto& [vertices, edge] : edges)
    if (vertices[0] % ranks == me) share.edges.push_back(edge);
  share.corners = mesh.corners;
  share.required_points = mesh.required_points;
  return share;
}

std::array<std::uint32_t, 3> sorted(std::array<std::uint32_t, 3> v) {
  std::ranges::sort(v);
  return v;
}

/// What one rank has, against the whole surface.
class Comparison {
 public:
  explicit Comparison(const MeshData& mesh) : mesh_(mesh), whole_(mesh, {}) {}

  /// Returns how many ranks can make pieces.
  std::size_t check(int ranks) {
    SCOPED_TRACE(ranks);
    made_.clear();
    makers_ = 0;
    support::run_ranks(ranks, [&](Peers& peers) {
      std::vector<std::string> warnings;
      const FetchPoints points = [&](const std::vector<std::uint32_t>& numbers) {
        std::vector<Point> found;
        for (const std::uint32_t v : numbers) found.push_back(mesh_.points[v]);
        return found;
      };
      SurfaceParts parts = build_surface_parts(peers, share_of(mesh_, peers), points, 45, nullptr, warnings);
      std::vector<std::uint32_t> all(mesh_.points.size());
      std::iota(all.begin(), all.end(), 0u);
      const BoundaryIndex index(peers, std::exchange(parts.records, {}), all);
      const std::lock_guard lock(mutex_);  // all ranks look at all
      check_tables(parts);
      check_index(index);
      check_pieces(peers, parts);
    });
    EXPECT_EQ(made_.size(), whole_.pieces().all().size());
    return makers_;
  }

  const Surface& whole() const { return whole_; }

 private:
  void check_tables(const SurfaceParts& parts) const {
    const Surface& found = parts.geometry->surface;
    ASSERT_EQ(found.patches().size(), whole_.patches().size());
    std::vector<std::uint64_t> triangles(found.patches().size());
    std::vector<bool> required(found.patches().size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) ++triangles[whole_.triangle_patch(t).value];
    for (const std::uint32_t t : mesh_.required_triangles) required[whole_.triangle_patch(t).value] = true;
    EXPECT_EQ(parts.triangles, triangles);
    EXPECT_EQ(parts.geometry->patch_required, required);
    for (std::size_t p = 0; p < triangles.size(); ++p) {
      EXPECT_EQ(found.patches()[p].ref, whole_.patches()[p].ref);
      EXPECT_EQ(found.patches()[p].planar, whole_.patches()[p].planar);
      EXPECT_EQ(found.patches()[p].normal, whole_.patches()[p].normal);
    }
    ASSERT_EQ(found.curves().size(), whole_.curves().size());
    for (std::size_t c = 0; c < found.curves().size(); ++c) {
      EXPECT_EQ(found.curves()[c].ref, whole_.curves()[c].ref);
      EXPECT_EQ(found.curves()[c].straight, whole_.curves()[c].straight);
      EXPECT_EQ(found.curves()[c].required, whole_.curves()[c].required);
    }
  }

  void check_index(const BoundaryIndex& index) const {
    for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
      const std::uint32_t at = index.vertex(v);
      if (at == BoundaryIndex::kNone) {
        EXPECT_EQ(whole_.vertex_kind(v), meshing::VertexKind::interior);
        continue;
      }
      EXPECT_EQ(index.kind(at), whole_.vertex_kind(v));
      EXPECT_EQ(index.hint(at), whole_.vertex_hint(v));
    }
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      EXPECT_EQ(index.patch(sorted(mesh_.triangles[t])), whole_.triangle_patch(t));
    for (const auto& [v, curve] : whole_.feature_edges()) EXPECT_EQ(index.curve(v[0], v[1]), curve);
  }

  void check_pieces(const Peers& peers, const SurfaceParts& parts) {
    if (!parts.cutter) return;
    const std::vector<std::uint32_t> ids = parts.cutter->ids();
    makers_ += !ids.empty();
    for (const std::uint32_t id : ids) {
      EXPECT_TRUE(made_.insert(id).second) << "made twice";
      ASSERT_LT(id, whole_.pieces().all().size());
      const auto piece = parts.cutter->piece(id), expected = whole_.pieces().all()[id];
      EXPECT_TRUE(std::ranges::equal(piece->bytes(), expected->bytes())) << "piece " << id;
      EXPECT_EQ(parts.cutter->box(id).lo, expected->box.lo);
      EXPECT_EQ(parts.cutter->box(id).hi, expected->box.hi);
    }
    const std::size_t all = mesh_.triangles.size();
    if (peers.ranks() == 8 && all > 1000 && ids.size() < whole_.pieces().all().size()) {
      EXPECT_LT(parts.mesh->triangles.size(), all * 3 / 5) << "a share and its rings";
    }
  }

  const MeshData& mesh_;
  const Surface whole_;
  std::mutex mutex_;
  std::set<std::uint32_t> made_;
  std::size_t makers_ = 0;
};

void expect_all_ranks_make_pieces(Comparison& comparison) {
  for (const int ranks : support::kNumbersOfRanks)
    EXPECT_EQ(comparison.check(ranks), static_cast<std::size_t>(ranks));
}

TEST(SurfaceParts, HearTheRecordsOfAllRanksOnAModel) {
  const auto model = std::make_shared<const meshing::Model>(meshing::frustum_model({0, 0, 0}, 1, 1, 2));
  const MeshData mesh = body(1);
  for (const bool fit : {true, false})
    support::run_ranks(3, [&](Peers& peers) {
      BoundaryShare share = share_of(mesh, peers);
      for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        if (mesh.points[v].z != 0 || static_cast<int>(v) % peers.ranks() != peers.rank()) continue;
        const meshing::OnFace on = model->closest_within(1, mesh.points[v]);
        share.on_model.faces.push_back({v, fit ? 2 : 9, on.at[0], on.at[1], 2});
      }
      const FetchPoints points = [&](const std::vector<std::uint32_t>& numbers) {
        std::vector<Point> found;
        for (const std::uint32_t v : numbers) found.push_back(mesh.points[v]);
        return found;
      };
      std::vector<std::string> warnings;
      build_surface_parts(peers, std::move(share), points, 45, model, warnings);
      const auto unfit = [](const std::string& w) { return w.find("do not fit") != std::string::npos; };
      EXPECT_EQ(std::ranges::any_of(warnings, unfit), !fit);
    });
}

TEST(SurfaceShares, AreTheWholeSurface) {
  for (unsigned seed = 0; seed < support::repetitions(2, 4); ++seed) {
    SCOPED_TRACE(seed);
    const MeshData mesh = body(seed);
    Comparison comparison(mesh);
    expect_all_ranks_make_pieces(comparison);
  }
}

TEST(SurfaceShares, KeepFeaturesOfAllKinds) {
  for (unsigned seed = 0; seed < support::repetitions(2, 6); ++seed) {
    SCOPED_TRACE(seed);
    MeshData mesh = body(seed);
    add_features(mesh, seed);
    Comparison comparison(mesh);
    EXPECT_GT(comparison.whole().curves().size(), 100u);
    expect_all_ranks_make_pieces(comparison);
  }
}

TEST(SurfaceShares, LendNormalsToFlatTriangles) {
  for (unsigned seed = 0; seed < support::repetitions(2, 6); ++seed) {
    SCOPED_TRACE(seed);
    MeshData mesh = body(seed);
    flatten(mesh, seed);
    Comparison comparison(mesh);
    for (const int ranks : support::kNumbersOfRanks) comparison.check(ranks);
  }
}

/// Where it is cut depends on an order of all triangles: one rank has all.
TEST(SurfaceShares, OfAMoebiusStripAreOne) {
  MeshData mesh = body(1);
  add_moebius_strip(mesh);
  Comparison comparison(mesh);
  for (const int ranks : support::kNumbersOfRanks) EXPECT_EQ(comparison.check(ranks), 1u);
}

TEST(SurfaceShares, MayBeFewerThanTheRanks) {
  MeshData mesh = support::two_tets();
  mesh.tets.clear();
  Comparison comparison(mesh);
  for (const int ranks : support::kNumbersOfRanks) comparison.check(ranks);
}

/// Two components of one rank and one of another, of which the second must be turned; and one alone.
TEST(JoinedPatches, AgreeWithMostOfTheirTriangles) {
  support::run_ranks(2, [&](Peers& peers) {
    std::vector<PatchComponent> mine;
    std::vector<ComponentLink> links;
    if (peers.rank() == 0) {
      mine = {{3, 1, 5, 1}, {9, 0, 4, 2}};
      links = {{0, 2, 1}};
    } else {
      mine = {{6, 1, 2, 1}};
      links = {{0, 2, 1}};
    }
    const auto joined = join_patches(peers, mine, links);
    ASSERT_TRUE(joined);
    EXPECT_EQ(joined->patch, (std::vector<std::uint32_t>{0, 1, 0}));
    EXPECT_EQ(joined->refs, (std::vector<std::int32_t>{1, 2}));
    // Of nine, one of the six is turned and two of the three: most are not.
    EXPECT_EQ(joined->turned, (std::vector<std::uint8_t>{1, 0, 0}));
    links.push_back({0, 2, 0});
    EXPECT_FALSE(join_patches(peers, mine, links));
  });
}

}  // namespace
}  // namespace weft::partition::surface_shares_test

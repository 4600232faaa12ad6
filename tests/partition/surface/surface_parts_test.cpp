// A surface built in shares is the whole one, whatever is cut by the shares' borders.
#include "partition/surface/surface_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
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

#include "meshing/base/error.h"
#include "meshing/geometry/model/analytic_model.h"
#include "meshing/geometry/model/model.h"
#include "meshing/geometry/model/model_classification.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/kernel/tet_mesh.h"
#include "partition/surface/joined_patches.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/support/meshes.h"
#include "tests/support/repetitions.h"

namespace weft::partition::surface_parts_test {
namespace {

using meshing::MeshData;
using meshing::Model;
using meshing::ModelClassification;
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

constexpr std::uint32_t kMoebiusSteps = 400;  // more triangles than a share of eight has

void add_moebius_strip(MeshData& mesh) {
  constexpr std::uint32_t kSteps = kMoebiusSteps;
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
  std::map<std::uint32_t, std::uint32_t> listed;
  for (const std::uint32_t v : mesh.corners) listed[v] |= meshing::kListedCorner;
  for (const std::uint32_t v : mesh.required_points) listed[v] |= meshing::kListedRequired;
  for (const auto& [v, flags] : listed)
    if (v % ranks == me) share.listed_points.push_back({v, flags});
  const auto take = [&](const auto& records, auto& mine) {
    for (const auto& r : records)
      if ((r.vertex + 1) % ranks == me) mine.push_back(r);
  };
  take(mesh.association.nodes, share.on_model.nodes);
  take(mesh.association.edges, share.on_model.edges);
  take(mesh.association.faces, share.on_model.faces);
  return share;
}

FetchPoints points_of(const MeshData& mesh) {
  return [&](const std::vector<std::uint32_t>& numbers) {
    std::vector<Point> found;
    for (const std::uint32_t v : numbers) found.push_back(mesh.points[v]);
    return found;
  };
}

std::array<std::uint32_t, 3> sorted(std::array<std::uint32_t, 3> v) {
  std::ranges::sort(v);
  return v;
}

/// What one rank has, against the whole surface.
class Comparison {
 public:
  explicit Comparison(const MeshData& mesh, std::shared_ptr<const Model> model = nullptr)
      : mesh_(mesh),
        classification_(model ? meshing::classify_on_model(mesh, model) : ModelClassification{}),
        whole_(mesh, {}, classification_) {}

  /// Returns how many ranks can make pieces.
  std::size_t check(int ranks) {
    SCOPED_TRACE(ranks);
    made_.clear();
    pieces_.clear();
    makers_ = 0;
    support::run_ranks(ranks, [&](Peers& peers) {
      std::vector<std::string> warnings;
      SurfaceParts parts = build_surface_parts(peers, share_of(mesh_, peers), points_of(mesh_), 45,
                                               classification_.model, warnings);
      std::vector<std::uint32_t> all(mesh_.points.size());
      std::iota(all.begin(), all.end(), 0u);
      const BoundaryIndex index(peers, std::exchange(parts.records, {}), all);
      const std::lock_guard lock(mutex_);  // all ranks look at all
      EXPECT_EQ(warnings, classification_.warnings);
      check_faults(parts.geometry->on_model);
      check_tables(parts);
      check_index(index);
      check_pieces(peers, parts);
      geometry_ = parts.geometry;
    });
    EXPECT_EQ(made_.size(), whole_.pieces().all().size());
    check_projections();
    return makers_;
  }

  const Surface& whole() const { return whole_; }
  const ModelClassification& classification() const { return classification_; }

 private:
  void check_faults(const meshing::ModelFaults& found) const {
    EXPECT_EQ(found.off, classification_.faults.off);
    EXPECT_EQ(found.largest, classification_.faults.largest);
    EXPECT_EQ(found.turned, classification_.faults.turned);
  }

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
      EXPECT_EQ(found.patches()[p].detail, whole_.patches()[p].detail);
      const meshing::PatchId patch(static_cast<std::uint32_t>(p));
      if (found.model()) {
        EXPECT_TRUE(std::ranges::equal(found.faces(patch), whole_.faces(patch)));
      }
    }
    ASSERT_EQ(found.curves().size(), whole_.curves().size());
    for (std::size_t c = 0; c < found.curves().size(); ++c) {
      EXPECT_EQ(found.curves()[c].ref, whole_.curves()[c].ref);
      EXPECT_EQ(found.curves()[c].straight, whole_.curves()[c].straight);
      EXPECT_EQ(found.curves()[c].required, whole_.curves()[c].required);
      const meshing::CurveId curve(static_cast<std::uint32_t>(c));
      if (found.model()) {
        EXPECT_EQ(found.edge(curve), whole_.edge(curve));
      }
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
      const auto has = [&](const std::vector<std::uint32_t>& list) {
        return std::ranges::count(list, v) > 0;
      };
      EXPECT_EQ((index.flags(at) & meshing::kListedCorner) != 0, has(mesh_.corners));
      EXPECT_EQ((index.flags(at) & meshing::kListedRequired) != 0, has(mesh_.required_points));
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
      pieces_.push_back(piece);
      EXPECT_EQ(parts.cutter->box(id).lo, expected->box.lo);
      EXPECT_EQ(parts.cutter->box(id).hi, expected->box.hi);
    }
    const std::size_t all = mesh_.triangles.size();
    if (peers.ranks() == 8 && all > 1000 && ids.size() < whole_.pieces().all().size()) {
      EXPECT_LT(parts.mesh->triangles.size(), all * 3 / 5) << "a share and its rings";
    }
  }

  /// Of points beside feature edges and triangles, with all pieces.
  void check_projections() const {
    meshing::SurfacePieces pieces;
    pieces.add(pieces_);
    const Surface found = geometry_->surface.part(std::move(pieces));
    const Point aside{1e-3, 2e-3, -1e-3};
    const auto bits = [](const Point& p) {
      return std::array{std::bit_cast<std::uint64_t>(p.x), std::bit_cast<std::uint64_t>(p.y),
                        std::bit_cast<std::uint64_t>(p.z)};
    };
    for (const auto& [v, curve] : whole_.feature_edges()) {
      const Point p = midpoint(mesh_.points[v[0]], mesh_.points[v[1]]) + aside;
      const auto on = [&](const Surface& s) {
        return s.project_to_curve(curve, p, whole_.vertex_kind(v[0]), whole_.vertex_hint(v[0]));
      };
      EXPECT_EQ(bits(on(found).x), bits(on(whole_).x));
      EXPECT_EQ(bits(on(found).tangent), bits(on(whole_).tangent));
      EXPECT_EQ(on(found).hint, on(whole_).hint);
    }
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); t += 5) {
      const auto& [a, b, c] = mesh_.triangles[t];
      const Point p = (1.0 / 3) * (mesh_.points[a] + mesh_.points[b] + mesh_.points[c]) + aside;
      const auto on = [&](const Surface& s) {
        return s.project_to_patch(whole_.triangle_patch(t), p, whole_.vertex_kind(a), whole_.vertex_hint(a));
      };
      EXPECT_EQ(bits(on(found).x), bits(on(whole_).x));
      EXPECT_EQ(bits(on(found).normal), bits(on(whole_).normal));
      EXPECT_EQ(on(found).hint, on(whole_).hint);
    }
  }

  const MeshData& mesh_;
  const ModelClassification classification_;
  const Surface whole_;
  std::shared_ptr<const Geometry> geometry_;
  std::vector<meshing::SurfacePieces::Piece> pieces_;
  std::mutex mutex_;
  std::set<std::uint32_t> made_;
  std::size_t makers_ = 0;
};

void expect_all_ranks_make_pieces(Comparison& comparison) {
  for (const int ranks : support::kNumbersOfRanks)
    EXPECT_EQ(comparison.check(ranks), static_cast<std::size_t>(ranks));
}

TEST(SurfaceParts, HearTheRecordsOfAllRanksOnAModel) {
  const auto model = std::make_shared<const Model>(meshing::frustum_model({0, 0, 0}, 1, 1, 2));
  const MeshData mesh = body(1);
  for (const bool fit : {true, false})
    support::run_ranks(3, [&](Peers& peers) {
      BoundaryShare share = share_of(mesh, peers);
      for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        if (mesh.points[v].z != 0 || static_cast<int>(v) % peers.ranks() != peers.rank()) continue;
        const meshing::OnFace on = model->closest_within(1, mesh.points[v]);
        share.on_model.faces.push_back({v, fit ? 2 : 9, on.at[0], on.at[1], 2});
      }
      std::vector<std::string> warnings;
      build_surface_parts(peers, std::move(share), points_of(mesh), 45, model, warnings);
      const auto unfit = [](const std::string& w) { return w.find("do not fit") != std::string::npos; };
      EXPECT_EQ(std::ranges::any_of(warnings, unfit), !fit);
    });
}

/// Bodies that change(mesh, seed) has changed: check(comparison).
template <class Change, class Check>
void compare_bodies(unsigned count, const Change& change, const Check& check) {
  for (unsigned seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(seed);
    MeshData mesh = body(seed);
    change(mesh, seed);
    Comparison comparison(mesh);
    check(comparison);
  }
}

TEST(SurfaceShares, AreTheWholeSurface) {
  compare_bodies(
      support::repetitions(2, 4), [](MeshData&, unsigned) {}, expect_all_ranks_make_pieces);
}

TEST(SurfaceShares, KeepFeaturesOfAllKinds) {
  compare_bodies(support::repetitions(2, 6), add_features, [](Comparison& comparison) {
    EXPECT_GT(comparison.whole().curves().size(), 100u);
    expect_all_ranks_make_pieces(comparison);
  });
}

TEST(SurfaceShares, LendNormalsToFlatTriangles) {
  compare_bodies(support::repetitions(2, 6), flatten, [](Comparison& comparison) {
    for (const int ranks : support::kNumbersOfRanks) comparison.check(ranks);
  });
}

/// A cylinder as body(1) is one.
std::shared_ptr<const meshing::GeometryModel> cylinder_model() {
  return meshing::frustum_model({0, 0, 0}, 1, 1, 2);
}

/// With formulas, and with parameters.
std::vector<std::shared_ptr<const Model>> cylinder_models() {
  return {std::make_shared<const Model>(cylinder_model()),
          std::make_shared<const Model>(meshing::without_formulas(cylinder_model()))};
}

bool is_on_lower_rim(const Point& p) { return p.z == 0 && p.x * p.x + p.y * p.y > 0.9; }

/// Of the lower end: on its face, its edge and its node; some are of another model.
void add_records(MeshData& mesh, const Model& model) {
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    const Point& p = mesh.points[v];
    if (p.z != 0) continue;
    const auto at = model.closest_within(1, p).at;
    mesh.association.faces.push_back({v, ++count % 15 == 0 ? 9 : 2, at[0], at[1], 0});
    if (is_on_lower_rim(p) && v % 2 == 0)
      mesh.association.edges.push_back({v, 1, model.closest_on_edge(0, p).t, 0});
    if (norm(p - model.node(0)) < 1e-9) mesh.association.nodes.push_back({v, 1});
  }
}

/// Vertices of the rim, but for one in `every`, are exactly on the lower end, and off the side by this: its
/// triangles there share no face.
void pull_from_side(MeshData& mesh, double by, std::uint32_t every) {
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    Point& p = mesh.points[v];
    if (is_on_lower_rim(p) && (every == 1 || v % every > 0)) p.x *= 1 - by, p.y *= 1 - by;
  }
}

/// Its triangles, of another reference.
void add_ball(MeshData& mesh, double radius, double x) {
  const MeshData ball = support::ball(3, 1);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (const Point& p : ball.points) mesh.points.push_back(radius * p + Point{x, 0, 0});
  mesh.point_refs.resize(mesh.points.size(), 0);
  for (const auto& [a, b, c] : ball.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  mesh.triangle_refs.resize(mesh.triangles.size(), 11);
}

TEST(SurfaceSharesOnAModel, AreTheWholeSurface) {
  const MeshData mesh = body(1);
  for (const auto& model : cylinder_models()) {
    SCOPED_TRACE(model->has_formulas());
    Comparison comparison(mesh, model);
    EXPECT_EQ(comparison.classification().nodes.size(), 2u);
    expect_all_ranks_make_pieces(comparison);
  }
}

TEST(SurfaceSharesOnAModel, KeepFeaturesAndRecords) {
  for (const auto& model : cylinder_models()) {
    MeshData mesh = body(1);
    add_features(mesh, 3);
    add_records(mesh, *model);
    Comparison comparison(mesh, model);
    EXPECT_FALSE(comparison.classification().warnings.empty());
    EXPECT_GT(comparison.classification().faults.turned, 100u);
    EXPECT_GT(comparison.whole().curves().size(), 100u);
    expect_all_ranks_make_pieces(comparison);
  }
}

TEST(SurfaceSharesOnAModel, FillGapsAndReconstructWhatLiesOnNoFace) {
  for (const auto& model : cylinder_models()) {
    MeshData mesh = body(1);
    pull_from_side(mesh, 0.01, 3);
    add_ball(mesh, 0.3, 5);
    Comparison comparison(mesh, model);
    const ModelClassification& c = comparison.classification();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      EXPECT_EQ(c.triangle_face[t] == meshing::kNoEntity, mesh.triangle_refs[t] == 11);
    EXPECT_GT(c.faults.off, 10u);
    EXPECT_FALSE(c.warnings.empty());
    for (const int ranks : support::kNumbersOfRanks) comparison.check(ranks);
  }
}

/// The lower rim is farther from its edge than its own edges are long: its triangles cross it.
TEST(SurfaceSharesOnAModel, AreOneWhereTheMeshDoesNotKeepFacesApart) {
  MeshData mesh = support::cylinder(120, 1, 30, 2);
  support::shuffle(mesh, 4);
  std::ranges::fill(mesh.triangle_refs, 3);
  pull_from_side(mesh, 0.02, 1);
  for (const auto& model : cylinder_models()) {
    Comparison comparison(mesh, model);
    EXPECT_EQ(comparison.classification().face_group, (std::vector<std::uint32_t>{0, 0, 2}));
    expect_all_ranks_make_pieces(comparison);
  }
}

TEST(SurfaceSharesOnAModel, CutAMoebiusStripAsTheWholeDoes) {
  MeshData mesh = body(1);
  add_moebius_strip(mesh);
  Comparison comparison(mesh, cylinder_models()[1]);
  expect_all_ranks_make_pieces(comparison);
}

std::string what_of(const std::exception_ptr& thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const meshing::InputError& error) {
    return error.what();
  }
  return "nothing";
}

/// Of the whole, and of all ranks; with these words.
void expect_refusal(const MeshData& mesh, const std::shared_ptr<const Model>& model,
                    const std::string& words) {
  std::string expected;
  try {
    meshing::classify_on_model(mesh, model);
  } catch (const meshing::InputError& error) {
    expected = error.what();
  }
  EXPECT_NE(expected.find(words), std::string::npos) << expected;
  for (const int ranks : support::kNumbersOfRanks) {
    const auto thrown = support::run_ranks_caught(ranks, [&](Peers& peers) {
      std::vector<std::string> warnings;
      build_surface_parts(peers, share_of(mesh, peers), points_of(mesh), 45, model, warnings);
    });
    for (const std::exception_ptr& of_rank : thrown) EXPECT_EQ(what_of(of_rank), expected);
  }
}

TEST(SurfaceSharesOnAModel, RefuseAnotherModelAsTheWholeDoes) {
  const std::shared_ptr<const Model> model = cylinder_models()[0];
  MeshData large = body(1), larger = large, with_ball = large;
  for (Point& p : large.points) p = 1.01 * p;
  expect_refusal(large, model, "as it is");
  for (Point& p : larger.points) p = 1.3 * p;
  expect_refusal(larger, model, "--geometry-scale");
  add_ball(with_ball, 3, 20);
  expect_refusal(with_ball, std::make_shared<const Model>(meshing::frustum_model({0, 0, 0}, 1, 1, 6)),
                 "of its area");
}

TEST(SurfaceShares, CutAMoebiusStripAsTheWholeDoes) {
  MeshData mesh = body(1);
  const std::size_t first = mesh.points.size();
  add_moebius_strip(mesh);
  Comparison comparison(mesh);
  const auto is_of_strip = [&](const Surface::FeatureEdge& f) { return f.vertices[0] >= first; };
  EXPECT_EQ(std::ranges::count_if(comparison.whole().feature_edges(), is_of_strip),
            2 * std::ptrdiff_t{kMoebiusSteps} + 1);  // its border, and the cut
  expect_all_ranks_make_pieces(comparison);
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
    const JoinedPatches joined = join_patches(peers, mine, links);
    EXPECT_EQ(joined.patch, (std::vector<std::uint32_t>{0, 1, 0}));
    EXPECT_EQ(joined.refs, (std::vector<std::int32_t>{1, 2}));
    EXPECT_EQ(joined.firsts, (std::vector<std::uint32_t>{2, 4}));
    EXPECT_EQ(joined.one_sided, (std::vector<std::uint8_t>{0, 0}));
    // Of nine, one of the six is turned and two of the three: most are not.
    EXPECT_EQ(joined.turned, (std::vector<std::uint8_t>{1, 0, 0}));
    links.push_back({0, 2, 0});
    EXPECT_EQ(join_patches(peers, mine, links).one_sided, (std::vector<std::uint8_t>{1, 0}));
  });
}

}  // namespace
}  // namespace weft::partition::surface_parts_test

// Tests of each operator on hand-made configurations: what it does, and why it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "meshing/operators/collapse_edge.h"
#include "meshing/operators/placement.h"
#include "meshing/operators/relocate_vertex.h"
#include "meshing/operators/smooth_vertex.h"
#include "meshing/operators/snap_vertex.h"
#include "meshing/operators/split_edge.h"
#include "meshing/operators/surface_fit.h"
#include "meshing/operators/swap_edge.h"
#include "meshing/operators/swap_face.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::operators_test {
namespace {

using support::expect_same_domain;
using support::expect_same_lengths;
using support::expect_sound;
using support::half_ring_of;
using support::KernelRig;
using support::kFaceted;
using support::octahedron;
using support::ring_of;
using support::unit_cube;

// --- one call of each operator, all claims released ---

Verdict split(KernelRig& rig, VertexId a, VertexId b, SplitBounds bounds = {0}) {
  const TetId t = rig.tet_with(a, b);
  Verdict r = rig.worker.claims.claim_tet(t);
  if (r == Verdict::accepted) r = split_edge(rig.worker, t, a, b, bounds);
  rig.worker.claims.release();
  return r;
}

Verdict collapse(KernelRig& rig, VertexId removed, VertexId kept, CollapseGoal goal = CollapseGoal::length) {
  Verdict r = gather_ball(rig.mesh, rig.worker.claims, removed, rig.worker.ball);
  if (r == Verdict::accepted) r = collapse_edge(rig.worker, removed, kept, goal);
  rig.worker.claims.release();
  return r;
}

Verdict swap(KernelRig& rig, VertexId a, VertexId b) {
  const TetId t = rig.tet_with(a, b);
  Verdict r = rig.worker.claims.claim_tet(t);
  if (r == Verdict::accepted) r = swap_edge(rig.worker, t, a, b);
  rig.worker.claims.release();
  return r;
}

Verdict swap(KernelRig& rig, TetId t, int face) {
  Verdict r = rig.worker.claims.claim_tet(t);
  if (r == Verdict::accepted) r = swap_face(rig.worker, t, face);
  rig.worker.claims.release();
  return r;
}

Verdict smooth(KernelRig& rig, VertexId v) {
  const Verdict r = smooth_vertex(rig.worker, v);
  rig.worker.claims.release();
  return r;
}

Verdict relocate(KernelRig& rig, VertexId v) {
  const Verdict r = relocate_vertex(rig.worker, v);
  rig.worker.claims.release();
  return r;
}

double worst(const KernelRig& rig) {
  double least = 1;
  for (const TetId t : rig.live_tets()) least = std::min<double>(least, rig.mesh.quality(t));
  return least;
}

/// The kernel's mesh is sound, and the exported one fills the same domain with the same faces and edges.
void expect_kept(KernelRig& rig) {
  expect_sound(rig.mesh);
  const MeshData data = rig.export_data();
  expect_same_domain(data, rig.input);
  if (!rig.input.edges.empty()) expect_same_lengths(data, rig.input);
}

/// Refused, and nothing has changed.
template <class Operation>
void expect_refused(KernelRig& rig, Verdict expected, Operation operation) {
  const auto state = [&] {
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (const TetId t : rig.live_tets()) {
      const TetVertices v = rig.mesh.vertices(t);
      tets.push_back({v[0].value, v[1].value, v[2].value, v[3].value});
    }
    return tets;
  };
  const auto points = [&] {
    std::vector<Point> x;
    for (const VertexId v : rig.live_vertices()) x.push_back(rig.mesh.point(v));
    return x;
  };
  const auto tets_before = state();
  const auto points_before = points();
  const auto features_before = rig.mesh.feature_edges().size();
  EXPECT_EQ(kVerdictNames[static_cast<std::size_t>(operation())],
            kVerdictNames[static_cast<std::size_t>(expected)]);
  EXPECT_EQ(state(), tets_before);
  EXPECT_EQ(points(), points_before);
  EXPECT_EQ(rig.mesh.feature_edges().size(), features_before);
  expect_sound(rig.mesh);
}

/// Rings whose edge is near one of their sides: thin tets there, which a swap gets rid of.
MeshData ring_off_centre(std::uint32_t n, double height) {
  MeshData mesh = ring_of(n, height);
  const Point towards = midpoint(mesh.points[2], mesh.points[3]);
  for (int i = 0; i < 2; ++i) mesh.points[i] += 0.8 * towards;
  return mesh;
}
MeshData half_ring_off_centre(std::uint32_t n, double length) {
  MeshData mesh = half_ring_of(n, length);
  for (int i = 0; i < 2; ++i) mesh.points[i].y = 0.8;
  return mesh;
}

/// A bar whose section is a triangle, in two lengths; its middle section (vertices 3, 4, 5) is the face of
/// two tets each of which has all of it.
MeshData triangular_bar() {
  std::vector<Point> points;
  for (int k = 0; k < 3; ++k)
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.1, 0.0}, {0.05, 1.0}})
      points.push_back({x, y, static_cast<double>(k)});
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const std::uint32_t end : {0u, 6u}) {
    tets.push_back({3, 4, 5, end});
    tets.push_back({end, end + 1, end + 2, 5});
    tets.push_back({end, end + 1, 5, 4});
  }
  for (auto& t : tets)
    if (six_volume(points[t[0]], points[t[1]], points[t[2]], points[t[3]]) < 0) std::swap(t[2], t[3]);
  return support::mesh_of(std::move(points), std::move(tets));
}

// --- split ---

TEST(SplitEdge, DoublesTheTetsOfAnInteriorShell) {
  for (std::uint32_t n = 3; n <= 9; ++n) {
    KernelRig rig(ring_of(n, 1), 1, kFaceted);
    ASSERT_EQ(split(rig, VertexId(0), VertexId(1)), Verdict::accepted);
    EXPECT_EQ(rig.live_tets().size(), 2 * n);
    const VertexId p = rig.vertex_at({0, 0, 0});
    EXPECT_EQ(rig.mesh.point(p), (Point{0, 0, 0}));
    EXPECT_EQ(rig.mesh.kind(p), VertexKind::interior);
    EXPECT_EQ(rig.neighbours_of(p).size(), n + 2);
    expect_kept(rig);
  }
}

TEST(SplitEdge, HoldsTheNewVertexUntilItIsReleased) {
  KernelRig rig(ring_of(5, 1), 1, kFaceted);
  const TetId t = rig.tet_with(VertexId(0), VertexId(1));
  const VertexOnEdge middle{{0, 0, 0}, rig.mesh.log_metric(VertexId(0)), VertexKind::interior, {}};
  const VertexId made = split_edge_at(rig.worker, VertexId(0), VertexId(1), std::span(&t, 1), middle);
  ASSERT_TRUE(made.valid());
  Claims other(rig.mesh, 2, false, support::kClaimable);
  EXPECT_EQ(other.claim(made), Verdict::conflict);
  rig.worker.claims.release();
  EXPECT_EQ(other.claim(made), Verdict::accepted);
  other.release();
}

TEST(SplitEdge, PutsAVertexOnAPlanarBoundary) {
  for (std::uint32_t n = 2; n <= 5; ++n) {
    KernelRig rig(half_ring_of(n, 1.3), 1, kFaceted);
    ASSERT_EQ(split(rig, VertexId(0), VertexId(1)), Verdict::accepted);
    EXPECT_EQ(rig.live_tets().size(), 2 * n);
    const VertexId p = rig.vertex_at({0, 0, 0});
    EXPECT_EQ(rig.mesh.point(p).z, 0);
    EXPECT_EQ(rig.mesh.kind(p), VertexKind::surface);
    expect_kept(rig);
  }
}

TEST(SplitEdge, PutsAVertexOnARidgeWhichStaysOne) {
  KernelRig rig(unit_cube(1));
  const VertexId a = rig.vertex_at({0, 0, 0}), b = rig.vertex_at({0, 0, 1});
  const CurveId curve = rig.mesh.curve(a, b);
  ASSERT_TRUE(curve.valid());
  ASSERT_EQ(split(rig, a, b), Verdict::accepted);
  const VertexId p = rig.vertex_at({0, 0, 0.5});
  EXPECT_EQ(rig.mesh.point(p), (Point{0, 0, 0.5}));
  EXPECT_EQ(rig.mesh.kind(p), VertexKind::ridge);
  EXPECT_EQ(rig.mesh.curve(a, p), curve);
  EXPECT_EQ(rig.mesh.curve(p, b), curve);
  EXPECT_FALSE(rig.mesh.curve(a, b).valid());
  expect_kept(rig);
}

TEST(SplitEdge, AnEdgeBetweenRidgesThatIsNoneIsOnTheSurface) {
  KernelRig rig(unit_cube(1));
  const VertexId a = rig.vertex_at({0, 0, 0});
  for (const VertexId b : rig.neighbours_of(a)) {
    if (norm2(rig.mesh.point(b)) != 2) continue;  // a diagonal of a side
    ASSERT_EQ(split(rig, a, b), Verdict::accepted);
    const VertexId p = rig.vertex_at(0.5 * rig.mesh.point(b));
    EXPECT_EQ(rig.mesh.kind(p), VertexKind::surface);
    break;
  }
  const VertexId opposite = rig.vertex_at({1, 1, 1});
  ASSERT_TRUE(rig.tet_with(a, opposite).valid());
  ASSERT_EQ(split(rig, a, opposite), Verdict::accepted);
  EXPECT_EQ(rig.mesh.kind(rig.vertex_at({0.5, 0.5, 0.5})), VertexKind::interior);
  expect_kept(rig);
}

TEST(SplitEdge, PutsAVertexOnAnInterface) {
  KernelRig rig(support::layered_box(1, 1, 2));
  const VertexId a = rig.vertex_at({0, 0, 1});
  const VertexId b =
      rig.tet_with(a, rig.vertex_at({1, 1, 1})).valid() ? rig.vertex_at({1, 1, 1}) : VertexId();
  ASSERT_TRUE(b.valid());
  ASSERT_EQ(split(rig, a, b), Verdict::accepted);
  const VertexId p = rig.vertex_at({0.5, 0.5, 1});
  EXPECT_EQ(rig.mesh.point(p), (Point{0.5, 0.5, 1}));
  EXPECT_EQ(rig.mesh.kind(p), VertexKind::surface);
  expect_kept(rig);
}

TEST(SplitEdge, PutsTheVertexWhereBothHalvesAreEquallyLong) {
  MeshData mesh = ring_of(5, 1);
  LogMetricField field;
  for (const Point& p : mesh.points) field.push_back(identity_tensor(-2 * (p.z + 1) * std::log(2.0)));
  KernelRig rig(mesh, field, kFaceted);
  ASSERT_EQ(split(rig, VertexId(0), VertexId(1)), Verdict::accepted);
  const VertexId p(rig.worker.mesh.tet_of(VertexId(0)).valid() ? rig.vertex_at({0, 0, 0}) : VertexId());
  const auto length = [&](VertexId v) {
    return edge_length(rig.mesh.point(v) - rig.mesh.point(p), rig.mesh.metric(v), rig.mesh.metric(p));
  };
  EXPECT_LT(rig.mesh.point(p).z, -0.1);
  EXPECT_NEAR(length(VertexId(0)) / length(VertexId(1)), 1, 0.02);
  const LogMetric expected = identity_tensor(-2 * (rig.mesh.point(p).z + 1) * std::log(2.0));
  EXPECT_NEAR(rig.mesh.log_metric(p).xx, expected.xx, 1e-12) << "not the background's metric";
}

TEST(SplitEdge, RefusesARequiredEdge) {
  MeshData mesh = unit_cube(2);
  for (std::uint32_t e = 0; e < mesh.edges.size(); ++e) mesh.required_edges.push_back(e);
  KernelRig rig(mesh, 0.1, kFaceted);
  expect_refused(rig, Verdict::required, [&] {
    return split(rig, rig.vertex_at({0, 0, 0}), rig.vertex_at({0, 0, 0.5}));
  });
}

TEST(SplitEdge, RefusesTheEdgesOfARequiredTriangle) {
  MeshData mesh = unit_cube(2);
  mesh.required_triangles.push_back(0);
  KernelRig rig(mesh, 0.1, kFaceted);
  const auto& t = mesh.triangles[0];
  for (int i = 0; i < 3; ++i)
    expect_refused(rig, Verdict::required,
                   [&] { return split(rig, VertexId(t[i]), VertexId(t[(i + 1) % 3])); });
}

TEST(SplitEdge, RefusesWhatWouldBeTooShort) {
  KernelRig rig(ring_of(5, 1), 1, kFaceted);
  expect_refused(rig, Verdict::too_short, [&] { return split(rig, VertexId(0), VertexId(1), {1.001}); });
  EXPECT_EQ(split(rig, VertexId(0), VertexId(1), {0.999}), Verdict::accepted);
}

TEST(SplitEdge, RefusesWhatWouldBePoor) {
  KernelRig rig(ring_of(4, 0.1), 1, kFaceted);
  rig.kernel.limits.split_quality = 0.9;
  expect_refused(rig, Verdict::worsens_quality, [&] { return split(rig, VertexId(0), VertexId(1), {0, 1}); });
}

TEST(SplitEdge, PutsTheVertexWhereItsTetsAreBest) {
  for (std::uint32_t n = 4; n <= 7; ++n) {
    KernelRig at_middle(ring_off_centre(n, 1), 1, kFaceted), at_best(ring_off_centre(n, 1), 1, kFaceted);
    const double before = worst(at_best);
    ASSERT_EQ(split(at_middle, VertexId(0), VertexId(1), {.shortest = 0, .keep_share = 0}),
              Verdict::accepted);
    ASSERT_EQ(
        split(at_best, VertexId(0), VertexId(1), {.shortest = 0.2, .must_improve = true, .at_best = true}),
        Verdict::accepted);
    EXPECT_GT(worst(at_best), 1.2 * before) << n;
    EXPECT_GT(worst(at_best), 1.2 * worst(at_middle)) << n;
    for (const VertexId v : at_best.live_vertices()) EXPECT_FALSE(at_best.mesh.marks(v) & kCheckShort);
    expect_kept(at_best);
  }
}

TEST(SplitEdge, AtItsBestPlaceAVertexMayNotBeNearTheEdgesEndsEither) {
  KernelRig rig(ring_off_centre(6, 0.25), 1, kFaceted);
  const SplitBounds bounds{.shortest = 0.8, .must_improve = true, .at_best = true};
  expect_refused(rig, Verdict::too_short, [&] { return split(rig, VertexId(0), VertexId(1), bounds); });
}

TEST(SplitEdge, OnABoundaryNoPlaceIsLookedFor) {
  KernelRig rig(half_ring_off_centre(5, 1), 1, kFaceted);
  const SplitBounds bounds{.shortest = 0, .must_improve = true, .at_best = true};
  expect_refused(rig, Verdict::not_needed, [&] { return split(rig, VertexId(0), VertexId(1), bounds); });
}

TEST(SplitEdge, RefusesWhatIsTooLarge) {
  KernelRig rig(ring_of(Shell::kMaxSize + 1, 1), 1, kFaceted);
  expect_refused(rig, Verdict::too_large, [&] { return split(rig, VertexId(0), VertexId(1)); });
}

TEST(SplitEdge, RefusesAFrozenRing) {
  KernelRig rig(ring_of(5, 1), 1, kFaceted);
  rig.mesh.freeze(VertexId(4));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  expect_refused(rig, Verdict::frozen, [&] { return split(rig, VertexId(0), VertexId(1)); });
}

bool on_surface(const KernelRig& rig, VertexId v) { return rig.mesh.kind(v) == VertexKind::surface; }

/// The first edge whose ends both lie on the boundary.
std::pair<VertexId, VertexId> edge_on_surface(KernelRig& rig) {
  const auto on_it = [&](VertexId v) { return on_surface(rig, v); };
  const auto vertices = rig.live_vertices();
  const VertexId a = *std::find_if(vertices.begin(), vertices.end(), on_it);
  const auto neighbours = rig.neighbours_of(a);
  return {a, *std::find_if(neighbours.begin(), neighbours.end(), on_it)};
}

TEST(SplitEdge, OnACurvedBoundaryTheVertexLiesOnTheReferenceSurface) {
  KernelRig rig(support::ball(1, 1), 0.3);
  const auto [a, b] = edge_on_surface(rig);
  const Point middle = midpoint(rig.mesh.point(a), rig.mesh.point(b));
  ASSERT_LT(norm(middle), 0.97);
  ASSERT_EQ(split(rig, a, b), Verdict::accepted);
  const VertexId p = rig.vertex_at(middle);
  EXPECT_TRUE(on_surface(rig, p));
  EXPECT_NEAR(norm(rig.mesh.point(p)), 1, 0.005);
  expect_sound(rig.mesh);
  EXPECT_TRUE(check_mesh(rig.export_data()).ok());
}

TEST(SplitEdge, OnTheChordTheVertexStaysThereRisesWhenToldAndCanBeTakenBack) {
  KernelRig rig(support::ball(1, 1), 0.3);
  const auto [a, b] = edge_on_surface(rig);
  const Point middle = midpoint(rig.mesh.point(a), rig.mesh.point(b));
  const std::size_t tets = rig.live_tets().size();
  const auto split_on_chord = [&] {
    VertexId made;
    const TetId t = rig.tet_with(a, b);
    EXPECT_EQ(rig.worker.claims.claim_tet(t), Verdict::accepted);
    EXPECT_EQ(split_edge(rig.worker, t, a, b, {.shortest = 0, .on_chord = true}, &made), Verdict::accepted);
    rig.worker.claims.release();
    return made;
  };
  const VertexId first = split_on_chord();
  EXPECT_NEAR(norm(rig.mesh.point(first) - middle), 0, 1e-12);
  // As a short edge it may not go: the edge that comes back is long and far from the surface.
  EXPECT_NE(collapse(rig, first, a), Verdict::accepted);
  EXPECT_EQ(collapse(rig, first, a, CollapseGoal::undo), Verdict::accepted);
  EXPECT_EQ(rig.live_tets().size(), tets);
  const VertexId second = split_on_chord();
  EXPECT_EQ(raise_vertex(rig.worker, second), Verdict::accepted);
  rig.worker.claims.release();
  EXPECT_NEAR(norm(rig.mesh.point(second)), 1, 0.005);
  expect_sound(rig.mesh);
  EXPECT_TRUE(check_mesh(rig.export_data()).ok());
}

TEST(CurvesTooMuch, AnEdgeUnderMoreThanThirtyDegreesHoweverFarTheBoundaryMayBulge) {
  for (const auto& [size, too_much] : {std::pair(0.1, true), std::pair(10.0, false)}) {
    KernelRig rig(support::ball(1, 1), size);
    rig.kernel.limits.hausd = 10;
    rig.kernel.limits.largest_bulge = 1000;
    const TetMesh& mesh = rig.mesh;
    int seen = 0;
    for (const TetId t : rig.live_tets())
      for (int f = 0; f < 4; ++f) {
        if (!mesh.patch(t, f).valid()) continue;
        const VertexId a = mesh.vertex(t, kTetFaces[f][0]), b = mesh.vertex(t, kTetFaces[f][1]);
        const double degrees = 2 * std::asin(norm(mesh.point(a) - mesh.point(b)) / 2) * 180 / 3.14159265;
        if (degrees < 35) continue;
        ++seen;
        // Edges that are short enough for the metric stay.
        EXPECT_EQ(curves_too_much(rig.kernel, a, b, mesh.patch(t, f)), too_much) << degrees;
      }
    EXPECT_GT(seen, 0);
  }
}

// --- collapse ---

TEST(CollapseEdge, AnInteriorVertexGoesIntoAnyBoundaryVertexThatSeesIt) {
  for (std::uint32_t kept = 1; kept <= 6; ++kept) {
    KernelRig rig(octahedron(), 2, kFaceted);
    ASSERT_EQ(collapse(rig, VertexId(0), VertexId(kept)), Verdict::accepted);
    EXPECT_EQ(rig.live_tets().size(), 4u);
    EXPECT_FALSE(rig.mesh.alive(VertexId(0)));
    expect_kept(rig);
  }
}

TEST(CollapseEdge, UndoesASplit) {
  for (std::uint32_t n = 3; n <= 8; ++n) {
    KernelRig rig(ring_of(n, 1), 2, kFaceted);
    ASSERT_EQ(split(rig, VertexId(0), VertexId(1)), Verdict::accepted);
    ASSERT_EQ(collapse(rig, rig.vertex_at({0, 0, 0}), VertexId(n % 2)), Verdict::accepted);
    EXPECT_EQ(rig.live_tets().size(), n);
    EXPECT_TRUE(rig.tet_with(VertexId(0), VertexId(1)).valid());
    expect_kept(rig);
  }
}

TEST(CollapseEdge, ForRoomGivesUpAVertexWhateverTheLengths) {
  KernelRig rig(octahedron(), 0.2, kFaceted);  // all edges are far too long
  expect_refused(rig, Verdict::too_long, [&] { return collapse(rig, VertexId(0), VertexId(1)); });
  ASSERT_EQ(collapse(rig, VertexId(0), VertexId(1), CollapseGoal::room), Verdict::accepted);
  EXPECT_EQ(rig.live_tets().size(), 4u);
}

TEST(CollapseEdge, MakesTheVerticesAroundWorthAnotherTry) {
  KernelRig rig(octahedron(), 2, kFaceted);
  for (const VertexId v : rig.live_vertices()) rig.mesh.mark(v, kStuck);
  ASSERT_EQ(collapse(rig, VertexId(0), VertexId(1)), Verdict::accepted);
  for (const VertexId v : rig.live_vertices()) EXPECT_FALSE(rig.mesh.marks(v) & kStuck);
}

TEST(CollapseEdge, RefusesToRemoveACorner) {
  KernelRig rig(unit_cube(2), 2);
  for (const VertexId kept : rig.neighbours_of(rig.vertex_at({0, 0, 0})))
    expect_refused(rig, Verdict::required, [&] { return collapse(rig, rig.vertex_at({0, 0, 0}), kept); });
}

TEST(CollapseEdge, RefusesToRemoveARequiredPoint) {
  MeshData mesh = unit_cube(2);
  std::uint32_t centre = 0;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.points[v] == Point{0.5, 0.5, 0.5}) centre = v;
  mesh.required_points.push_back(centre);
  KernelRig rig(mesh, 2, kFaceted);
  for (const VertexId kept : rig.neighbours_of(VertexId(centre)))
    expect_refused(rig, Verdict::required, [&] { return collapse(rig, VertexId(centre), kept); });
}

TEST(CollapseEdge, RefusesToRemoveAVertexOfARequiredTriangle) {
  MeshData mesh = unit_cube(3);
  std::uint32_t inner = 0;  // a triangle with a vertex inside a side
  const auto inside = [&](std::uint32_t v) {
    const Point& p = mesh.points[v];
    return p.x == 0 && p.y > 0 && p.y < 1 && p.z > 0 && p.z < 1;
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (std::ranges::count_if(mesh.triangles[t], inside) > 0) inner = t;
  mesh.required_triangles.push_back(inner);
  KernelRig rig(mesh, 2, kFaceted);
  for (const std::uint32_t v : mesh.triangles[inner])
    for (const VertexId kept : rig.neighbours_of(VertexId(v)))
      expect_refused(rig, Verdict::required, [&] { return collapse(rig, VertexId(v), kept); });
}

TEST(CollapseEdge, ARidgeVertexGoesOnlyAlongItsRidge) {
  KernelRig rig(unit_cube(2), 2);
  const VertexId removed = rig.vertex_at({0.5, 0, 0});
  ASSERT_EQ(rig.mesh.kind(removed), VertexKind::ridge);
  for (const VertexId kept : rig.neighbours_of(removed)) {
    const Point& p = rig.mesh.point(kept);
    if (p.y == 0 && p.z == 0) continue;
    expect_refused(rig, Verdict::breaks_classification, [&] { return collapse(rig, removed, kept); });
  }
  ASSERT_EQ(collapse(rig, removed, rig.vertex_at({0, 0, 0})), Verdict::accepted);
  EXPECT_TRUE(rig.mesh.curve(rig.vertex_at({0, 0, 0}), rig.vertex_at({1, 0, 0})).valid());
  expect_kept(rig);
}

TEST(CollapseEdge, ASurfaceVertexGoesOnlyAlongItsPatch) {
  KernelRig rig(unit_cube(2), 2);
  const VertexId removed = rig.vertex_at({0.5, 0.5, 0});
  ASSERT_EQ(rig.mesh.kind(removed), VertexKind::surface);
  int accepted_ways = 0;
  for (const VertexId kept : rig.neighbours_of(removed))
    if (rig.mesh.point(kept).z > 0)
      expect_refused(rig, Verdict::breaks_classification, [&] { return collapse(rig, removed, kept); });
  for (const VertexId kept : rig.neighbours_of(removed)) {
    if (rig.mesh.point(kept).z > 0) continue;
    KernelRig fresh(unit_cube(2), 2);
    accepted_ways += collapse(fresh, removed, kept) == Verdict::accepted;
    expect_kept(fresh);
  }
  EXPECT_GT(accepted_ways, 0);
}

TEST(CollapseEdge, AnInterfaceVertexGoesOnlyAlongTheInterface) {
  KernelRig rig(support::layered_box(2, 2, 2), 4);
  const VertexId removed = rig.vertex_at({0.5, 0.5, 1});
  ASSERT_EQ(rig.mesh.kind(removed), VertexKind::surface);
  bool done = false;
  for (const VertexId kept : rig.neighbours_of(removed))
    if (rig.mesh.point(kept).z != 1)
      expect_refused(rig, Verdict::breaks_classification, [&] { return collapse(rig, removed, kept); });
  for (const VertexId kept : rig.neighbours_of(removed))
    if (!done && rig.mesh.point(kept).z == 1) done = collapse(rig, removed, kept) == Verdict::accepted;
  EXPECT_TRUE(done);
  expect_kept(rig);
}

TEST(CollapseEdge, RefusesToInvert) {
  // Vertex 1 is pushed in beyond the middle: 3 does not see the faces on its other side.
  MeshData mesh = octahedron({-0.5, 0, 0});
  mesh.points[1] = {-0.2, 0, 0};
  KernelRig rig(mesh, 2, kFaceted);
  expect_refused(rig, Verdict::inverts, [&] { return collapse(rig, VertexId(0), VertexId(3)); });
}

TEST(CollapseEdge, RefusesEdgesThatAreTooLong) {
  KernelRig rig(octahedron(), 1, kFaceted);
  expect_refused(rig, Verdict::too_long, [&] { return collapse(rig, VertexId(0), VertexId(3)); });
}

TEST(CollapseEdge, RefusesTetsThatArePoor) {
  KernelRig rig(octahedron({0.33, 0.33, 0.33}), 2, kFaceted);  // a flat tet on one side
  EXPECT_EQ(collapse(rig, VertexId(0), VertexId(1), CollapseGoal::quality), Verdict::accepted);
  expect_kept(rig);
  KernelRig good(octahedron(), 2, kFaceted);
  expect_refused(good, Verdict::worsens_quality,
                 [&] { return collapse(good, VertexId(0), VertexId(1), CollapseGoal::quality); });
}

TEST(CollapseEdge, RefusesATetThatLiesUponACurvedSurface) {
  KernelRig rig(support::ball(0, 1), 4);
  expect_refused(rig, Verdict::breaks_topology, [&] { return collapse(rig, VertexId(0), VertexId(1)); });
}

TEST(CollapseEdge, RefusesFrozenNeighboursAndThoseThatOthersHold) {
  KernelRig rig(octahedron(), 2, kFaceted);
  Claims other(rig.mesh, 2, false, support::kClaimable);
  ASSERT_EQ(other.claim(VertexId(4)), Verdict::accepted);
  EXPECT_EQ(collapse(rig, VertexId(0), VertexId(1)), Verdict::conflict);
  other.release();
  rig.mesh.freeze(VertexId(4));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  expect_refused(rig, Verdict::frozen, [&] { return collapse(rig, VertexId(0), VertexId(1)); });
}

TEST(CollapseEdge, OnASphereKeepsTheSphereASphere) {
  KernelRig rig(support::ball(2, 2), 2);
  rig.kernel.limits.hausd = 0.1;
  int accepted = 0, tries = 0;
  for (const VertexId v : rig.live_vertices()) {
    if (!rig.mesh.alive(v)) continue;
    for (const VertexId kept : rig.neighbours_of(v)) {
      ++tries;
      if (collapse(rig, v, kept) != Verdict::accepted) continue;
      ++accepted;
      break;
    }
  }
  EXPECT_GT(accepted, 20) << "of " << tries;
  expect_sound(rig.mesh);
  const MeshData data = rig.export_data();
  const CheckReport report = check_mesh(data);
  for (const auto& problem : report.problems) ADD_FAILURE() << problem;
  // Euler's number of the boundary: still a sphere.
  std::set<std::uint32_t> vertices;
  for (const auto& t : data.triangles) vertices.insert(t.begin(), t.end());
  EXPECT_EQ(2 * vertices.size(), 4 + data.triangles.size());
}

TEST(CollapseEdge, DoesNotCutABarInTwo) {
  constexpr double kNoRidges = 179, kCoarse = 10;
  KernelRig rig(triangular_bar(), kCoarse, kNoRidges);
  rig.kernel.limits.hausd = 10;
  expect_refused(rig, Verdict::breaks_topology, [&] { return collapse(rig, VertexId(3), VertexId(4)); });
}

// --- swaps ---

TEST(SwapEdge, ThreeTetsBecomeTwo) {
  KernelRig rig(ring_of(3, std::sqrt(2.0)), 1, kFaceted);
  const double before = worst(rig);
  ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted);
  EXPECT_EQ(rig.live_tets().size(), 2u);
  EXPECT_GT(worst(rig), before);
  EXPECT_NEAR(worst(rig), 1, 1e-6) << "two regular tets";
  EXPECT_FALSE(rig.tet_with(VertexId(0), VertexId(1)).valid());
  expect_kept(rig);
}

TEST(SwapFace, TwoTetsBecomeThreeAndBackAgain) {
  MeshData two = support::mesh_of(
      {{0, 0, -0.3}, {0, 0, 0.3}, {1, 0, 0}, {-0.5, std::sqrt(0.75), 0}, {-0.5, -std::sqrt(0.75), 0}},
      {{2, 3, 4, 1}, {2, 4, 3, 0}});
  KernelRig rig(two, 1, kFaceted);
  const TetId t = rig.tet_with(VertexId(1), VertexId(2));
  ASSERT_EQ(swap(rig, t, rig.mesh.local_index(t, VertexId(1))), Verdict::accepted);
  EXPECT_EQ(rig.live_tets().size(), 3u);
  EXPECT_TRUE(rig.tet_with(VertexId(0), VertexId(1)).valid());
  expect_sound(rig.mesh);
  // The same domain in another metric: the edge has become far too long.
  for (const VertexId v : rig.live_vertices()) {
    const Metric m{1, 0, 1, 0, 0, 100};
    rig.mesh.set_metric(v, log_of(m), m);
  }
  rig.judge_by(MetricMean::arithmetic);
  ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted);
  EXPECT_EQ(rig.live_tets().size(), 2u);
  expect_kept(rig);
}

TEST(SwapEdge, FourTetsTurnTheirEdge) {
  KernelRig rig(ring_of(4, 1.6), 1, kFaceted);
  const double before = worst(rig);
  ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted);
  EXPECT_EQ(rig.live_tets().size(), 4u);
  EXPECT_GT(worst(rig), before);
  EXPECT_FALSE(rig.tet_with(VertexId(0), VertexId(1)).valid());
  expect_kept(rig);
}

TEST(SwapEdge, RingsOfUpToNineAreTriangulated) {
  for (std::uint32_t n = 5; n <= kMaxRing; ++n) {
    KernelRig rig(ring_off_centre(n, 4), 1, kFaceted);
    const double before = worst(rig);
    ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted) << n;
    EXPECT_EQ(rig.live_tets().size(), 2 * (n - 2));
    EXPECT_GT(worst(rig), before);
    EXPECT_FALSE(rig.tet_with(VertexId(0), VertexId(1)).valid());
    expect_kept(rig);
  }
}

TEST(SwapEdge, FindsTheBestTriangulationOfTheRing) {
  // The dynamic program against all triangulations of a pentagon, each a fan.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  int swapped = 0;
  for (int trial = 0; trial < 50; ++trial) {
    MeshData mesh = ring_of(5, 2.5);
    for (Point& p : mesh.points) {
      const double x = shift(random), y = shift(random), z = shift(random);
      p += Point{x, y, z};
    }
    KernelRig rig(mesh, 1, kFaceted);
    double best = -1;
    for (std::uint32_t apex = 0; apex < 5; ++apex) {
      double least = 1;
      for (std::uint32_t i = 1; i <= 3; ++i) {
        const VertexId u(2 + apex), v(2 + (apex + i) % 5), w(2 + (apex + i + 1) % 5);
        least = std::min({least, judge_quality(MetricMean::arithmetic, rig.mesh, {u, v, w, VertexId(1)}),
                          judge_quality(MetricMean::arithmetic, rig.mesh, {v, u, w, VertexId(0)})});
      }
      best = std::max(best, least);
    }
    const double before = worst(rig);
    const Verdict r = swap(rig, VertexId(0), VertexId(1));
    if (best > 1.02 * before + 2e-3) {
      EXPECT_EQ(r, Verdict::accepted);
    }
    if (best <= before) {
      EXPECT_EQ(r, Verdict::worsens_quality);
    }
    if (r != Verdict::accepted) continue;
    ++swapped;
    EXPECT_NEAR(worst(rig), best, 1e-6);
    expect_kept(rig);
  }
  EXPECT_GT(swapped, 10);
}

TEST(SwapEdge, RefusesWhatIsNoBetter) {
  KernelRig rig(ring_of(5, 0.6), 1, kFaceted);
  expect_refused(rig, Verdict::worsens_quality, [&] { return swap(rig, VertexId(0), VertexId(1)); });
}

TEST(SwapEdge, RefusesWhatIsTooLarge) {
  KernelRig rig(ring_of(kMaxRing + 1, 4), 1, kFaceted);
  expect_refused(rig, Verdict::too_large, [&] { return swap(rig, VertexId(0), VertexId(1)); });
}

TEST(SwapEdge, ABoundaryEdgeTurnsWithinItsPlane) {
  for (std::uint32_t n = 2; n <= 6; ++n) {
    KernelRig rig(half_ring_off_centre(n, 4), 1, kFaceted);
    ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted) << n;
    EXPECT_TRUE(rig.tet_with(VertexId(2), VertexId(n + 2)).valid());
    EXPECT_FALSE(rig.tet_with(VertexId(0), VertexId(1)).valid());
    expect_kept(rig);
  }
}

// --- boundary that is farther from the surface than it may be ---

/// The side of a cylinder about the z axis, where no triangle is as near to the surface as is wanted.
struct FarCylinder : KernelRig {
  FarCylinder() : KernelRig(support::cylinder(16, 2, 4, 1), 0.3) { kernel.limits.hausd = 1e-5; }
};

double angle_of(const KernelRig& rig, VertexId v) {
  return std::atan2(rig.mesh.point(v).y, rig.mesh.point(v).x);
}
/// From u to v, the short way.
double angle_between(const KernelRig& rig, VertexId u, VertexId v) {
  return std::remainder(angle_of(rig, v) - angle_of(rig, u), 2 * std::numbers::pi);
}
void turn(KernelRig& rig, VertexId v, double by) {
  const Point p = rig.mesh.point(v);
  const double c = std::cos(by), s = std::sin(by);
  rig.mesh.set_point(v, {c * p.x - s * p.y, s * p.x + c * p.y, p.z});
}

/// An edge of the side that runs across its quadrangle, and the one that a swap makes of it.
struct Diagonals {
  VertexId a, b, c, d;
};
Diagonals diagonals_on_side(KernelRig& rig) {
  for (const TetId t : rig.live_tets())
    for (const auto& e : kTetEdges) {
      const VertexId a = rig.mesh.vertex(t, e[0]), b = rig.mesh.vertex(t, e[1]);
      EXPECT_EQ(rig.worker.claims.claim_tet(t), Verdict::accepted);
      EXPECT_EQ(gather_shell(rig.mesh, rig.worker.claims, t, a, b, rig.worker.shell), Verdict::accepted);
      rig.worker.claims.release();
      const Shell& shell = rig.worker.shell;
      const VertexId c = shell.ring[0], d = shell.ring[shell.size];
      const auto on_side = [&](VertexId v) { return rig.mesh.kind(v) == VertexKind::surface; };
      const auto spans = [&](VertexId u, VertexId v) { return std::abs(angle_between(rig, u, v)) > 0.1; };
      if (shell.closed || !spans(a, b) || !spans(c, d)) continue;
      if (on_side(a) && on_side(b) && on_side(c) && on_side(d) && rig.mesh.flags(a) & kOnCurved)
        return {a, b, c, d};
    }
  ADD_FAILURE() << "none";
  return {};
}

/// As if all tets were poor, so that any swap improves them.
void call_all_poor(KernelRig& rig) {
  for (const TetId t : rig.live_tets()) rig.mesh.set_quality(t, 0.01f);
}

TEST(SwapEdge, WhereTheBoundaryIsTooFarFromTheSurfaceAnEdgeMayBecomeOneThatIsNearer) {
  FarCylinder rig;
  const auto [a, b, c, d] = diagonals_on_side(rig);
  turn(rig, a, 0.3 * angle_between(rig, b, a));
  call_all_poor(rig);
  EXPECT_EQ(swap(rig, a, b), Verdict::accepted);
  EXPECT_TRUE(rig.tet_with(c, d).valid());
  call_all_poor(rig);
  EXPECT_EQ(swap(rig, c, d), Verdict::leaves_surface) << "and not one that is farther";
  rig.judge_by(MetricMean::arithmetic);
  expect_sound(rig.mesh);
}

TEST(MoveOnSurface, WhereTheBoundaryIsTooFarFromTheSurfaceAVertexMayStillComeNearer) {
  KernelRig rig(support::cylinder(16, 2, 4, 1), 0.3);
  const auto [a, b, c, d] = diagonals_on_side(rig);
  const VertexId beside = std::abs(angle_between(rig, a, c)) > 0.1 ? c : d;
  const auto off = [&] { return largest_surface_deviation(rig.mesh, rig.kernel.surface); };
  // As far as all triangles are: those between the two that are out of place are too far, and stay so.
  rig.kernel.limits.hausd = 1.05 * off();
  const double out = 0.25 * angle_between(rig, beside, a);
  turn(rig, a, out);
  turn(rig, beside, -out);
  ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, a, rig.worker.ball), Verdict::accepted);
  MoveSpace space;
  ASSERT_EQ(move_space(rig.worker, a, space), Verdict::accepted);
  const auto may_turn = [&](double by) {
    const Point here = rig.mesh.point(a);
    turn(rig, a, by);
    const Point there = rig.mesh.point(a);
    rig.mesh.set_point(a, here);
    MovedVertex moved;
    return move_to(rig.worker, a, space, there, moved);
  };
  EXPECT_TRUE(may_turn(-0.5 * out));
  EXPECT_FALSE(may_turn(0.5 * out));
  rig.worker.claims.release();
}

TEST(SwapEdge, MarksTheEndsOfANewEdgeThatIsShort) {
  for (const bool boundary : {false, true}) {
    KernelRig rig(boundary ? half_ring_off_centre(2, 4) : ring_off_centre(4, 4), 10, kFaceted);
    for (const VertexId v : rig.live_vertices()) rig.mesh.take_marks(v, kCheckShort);
    ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted);
    std::size_t marked = 0;
    for (const VertexId v : rig.live_vertices()) marked += rig.mesh.take_marks(v, kCheckShort);
    EXPECT_EQ(marked, 2u);
  }
}

TEST(SwapEdge, RefusesARidge) {
  KernelRig rig(unit_cube(2), 0.5);
  expect_refused(rig, Verdict::breaks_classification, [&] {
    return swap(rig, rig.vertex_at({0, 0, 0}), rig.vertex_at({0, 0, 0.5}));
  });
}

TEST(SwapEdge, RefusesAnEdgeBetweenPatchesOfDifferentReference) {
  MeshData mesh = half_ring_of(3, 4);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto has = [&](std::uint32_t v) { return std::ranges::count(mesh.triangles[i], v) > 0; };
    if (has(0) && has(1) && has(2)) mesh.triangle_refs[i] = 7;
  }
  KernelRig rig(mesh, 1, kFaceted);
  expect_refused(rig, Verdict::breaks_classification, [&] { return swap(rig, VertexId(0), VertexId(1)); });
}

/// A half ring of one material above the plane z = 0 and its mirror image of another below.
MeshData two_half_rings(std::uint32_t n, double length) {
  MeshData mesh = half_ring_off_centre(n, length);
  const auto mirrored = [n](std::uint32_t v) { return v <= 2 || v == n + 2 ? v : v + n; };
  for (std::uint32_t v = 3; v < n + 2; ++v) {
    const Point p = mesh.points[v];
    mesh.points.push_back({p.x, p.y, -p.z});
    mesh.point_refs.push_back(0);
  }
  for (std::uint32_t t = 0; t < n; ++t) {
    const auto [i, j, k, l] = mesh.tets[t];
    mesh.tets.push_back({mirrored(i), mirrored(j), mirrored(l), mirrored(k)});
    mesh.tet_refs.push_back(2);
  }
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  support::add_boundary_triangles(mesh);
  return mesh;
}

TEST(SwapEdge, AnEdgeOfAnInterfaceTurnsWithinItsPlaneForBothMaterials) {
  for (std::uint32_t n = 2; n <= 6; ++n) {
    const MeshData mesh = two_half_rings(n, 4);
    ASSERT_TRUE(check_mesh(mesh).ok());
    KernelRig rig(mesh, 1, kFaceted);
    const double before = worst(rig);
    ASSERT_EQ(swap(rig, VertexId(0), VertexId(1)), Verdict::accepted) << n;
    EXPECT_GT(worst(rig), before);
    EXPECT_FALSE(rig.tet_with(VertexId(0), VertexId(1)).valid());
    EXPECT_TRUE(rig.tet_with(VertexId(2), VertexId(n + 2)).valid());
    expect_kept(rig);
  }
}

TEST(SwapFace, RefusesTheFacesOfAnInterface) {
  KernelRig rig(support::layered_box(2, 2, 2), 0.5);
  int faces = 0;
  for (const TetId t : rig.live_tets())
    for (int f = 0; f < 4; ++f) {
      if (!rig.mesh.patch(t, f).valid() || !rig.mesh.neighbour(t, f).valid()) continue;
      ++faces;
      EXPECT_EQ(swap(rig, t, f), Verdict::breaks_classification);
    }
  EXPECT_EQ(faces, 2 * 8);
  expect_kept(rig);
}

TEST(SwapFace, RefusesTheBoundary) {
  KernelRig rig(support::two_tets(), 1, kFaceted);
  for (const TetId t : rig.live_tets())
    for (int f = 0; f < 4; ++f)
      if (!rig.mesh.neighbour(t, f).valid())
        expect_refused(rig, Verdict::breaks_classification, [&] { return swap(rig, t, f); });
}

TEST(SwapFace, RefusesToInvert) {
  // The line between the apexes passes beside the face.
  const MeshData mesh = support::mesh_of({{1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}, {3, 0, 0.4}, {3, 0, -0.4}},
                                         {{0, 1, 2, 3}, {0, 2, 1, 4}});
  KernelRig rig(mesh, 1, kFaceted);
  for (const TetId t : rig.live_tets())
    for (int f = 0; f < 4; ++f) {
      if (!rig.mesh.neighbour(t, f).valid()) continue;
      const Verdict r = swap(rig, t, f);
      EXPECT_TRUE(r == Verdict::inverts || r == Verdict::worsens_quality);
    }
  EXPECT_EQ(rig.live_tets().size(), 2u);
  expect_kept(rig);
}

TEST(SwapEdge, RefusesAFrozenRingAndSwapFaceAFrozenApex) {
  KernelRig rig(ring_of(4, 4), 1, kFaceted);
  rig.mesh.freeze(VertexId(4));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  expect_refused(rig, Verdict::frozen, [&] { return swap(rig, VertexId(0), VertexId(1)); });
  KernelRig two(support::two_tets(), 1, kFaceted);
  two.mesh.freeze(VertexId(4));
  two.kernel.policy.frozen = FrozenPolicy::untouchable;
  const TetId t = two.tet_with(VertexId(0), VertexId(3));
  expect_refused(two, Verdict::frozen, [&] { return swap(two, t, two.mesh.local_index(t, VertexId(3))); });
}

TEST(SwapEdge, LeavesASwapToTheWorstTetOfTheShell) {
  MeshData mesh = ring_of(5, 4);
  mesh.points[3] = 0.7 * mesh.points[3];
  KernelRig rig(mesh, 1, kFaceted);
  TetId worst_tet = rig.live_tets()[0], other;
  for (const TetId t : rig.live_tets())
    if (rig.mesh.quality(t) < rig.mesh.quality(worst_tet)) worst_tet = t;
  for (const TetId t : rig.live_tets())
    if (t != worst_tet) other = t;
  rig.mesh.mark(worst_tet, kCheckSwap);
  ASSERT_EQ(rig.worker.claims.claim_tet(other), Verdict::accepted);
  EXPECT_EQ(swap_edge(rig.worker, other, VertexId(0), VertexId(1)), Verdict::not_needed);
  EXPECT_EQ(swap_edge(rig.worker, worst_tet, VertexId(0), VertexId(1)), Verdict::accepted);
  rig.worker.claims.release();
  expect_kept(rig);
}

// --- moves ---

class MoveVertex : public testing::TestWithParam<MetricMean> {};

TEST_P(MoveVertex, SmoothingBringsTheCentreOfAnOctahedronHome) {
  KernelRig rig(octahedron({0.3, -0.2, 0.4}), 1, kFaceted);
  rig.judge_by(GetParam());
  const double before = worst(rig);
  ASSERT_EQ(smooth(rig, VertexId(0)), Verdict::accepted);
  for (int i = 0; i < 10; ++i) smooth(rig, VertexId(0));
  EXPECT_GT(worst(rig), before);
  EXPECT_LT(norm(rig.mesh.point(VertexId(0))), 0.03);
  EXPECT_EQ(smooth(rig, VertexId(0)), Verdict::not_needed);
  expect_kept(rig);
}

TEST_P(MoveVertex, RelocationRepairsAnInteriorVertex) {
  KernelRig rig(octahedron({0.45, 0.25, 0.28}), 1, kFaceted);
  rig.judge_by(GetParam());
  const double before = worst(rig);
  ASSERT_LT(before, 0.2);
  ASSERT_EQ(relocate(rig, VertexId(0)), Verdict::accepted);
  EXPECT_GT(worst(rig), 0.7);
  EXPECT_EQ(rig.mesh.point(VertexId(0)), rig.mesh.point(rig.vertex_at({0, 0, 0})));
  expect_kept(rig);
}

TEST_P(MoveVertex, AMoveMakesAllVerticesOfTheBallWorthAnotherTry) {
  KernelRig rig(octahedron({0.3, -0.2, 0.4}), 1, kFaceted);
  rig.judge_by(GetParam());
  for (const VertexId v : rig.live_vertices()) rig.mesh.mark(v, kStuck);
  ASSERT_EQ(smooth(rig, VertexId(0)), Verdict::accepted);
  for (const VertexId v : rig.live_vertices()) EXPECT_FALSE(rig.mesh.marks(v) & kStuck);
}

TEST_P(MoveVertex, AMovedVertexReadsTheMetricWhereItIsNow) {
  MeshData mesh = octahedron({0.3, -0.2, 0.4});
  LogMetricField field;
  for (const Point& p : mesh.points) field.push_back(identity_tensor(0.3 * p.x - 0.2 * p.z));
  KernelRig rig(mesh, field, kFaceted);
  rig.judge_by(GetParam());
  ASSERT_EQ(smooth(rig, VertexId(0)), Verdict::accepted);
  const Point& p = rig.mesh.point(VertexId(0));
  EXPECT_NEAR(rig.mesh.log_metric(VertexId(0)).yy, 0.3 * p.x - 0.2 * p.z, 1e-12);
  expect_kept(rig);
}

TEST_P(MoveVertex, AVertexOfAPlaneStaysInItAndOneOfARidgeOnIt) {
  MeshData mesh = unit_cube(3);
  for (Point& p : mesh.points)
    for (int i = 0; i < 3; ++i)
      if (p[i] > 0 && p[i] < 1) p[i] = p[i] * p[i];  // off balance; every vertex stays where it belongs
  KernelRig rig(mesh, 0.3, kFaceted);
  rig.judge_by(GetParam());
  std::map<VertexKind, int> moved;
  for (const VertexId v : rig.live_vertices()) {
    const Point before = rig.mesh.point(v);
    if (smooth(rig, v) != Verdict::accepted) {
      EXPECT_EQ(rig.mesh.point(v), before);
      continue;
    }
    ++moved[rig.mesh.kind(v)];
    for (int i = 0; i < 3; ++i)
      if (before[i] == 0 || before[i] == 1) {
        EXPECT_EQ(rig.mesh.point(v)[i], before[i]) << "exactly";
      }
  }
  EXPECT_GT(moved[VertexKind::interior], 0);
  EXPECT_GT(moved[VertexKind::surface], 0);
  EXPECT_GT(moved[VertexKind::ridge], 0);
  EXPECT_EQ(moved[VertexKind::corner], 0);
  expect_kept(rig);
}

TEST_P(MoveVertex, NeverMovesAFixedOrFrozenVertex) {
  MeshData mesh = octahedron({0.3, -0.2, 0.4});
  mesh.required_points.push_back(0);
  KernelRig required(mesh, 1, kFaceted);
  required.judge_by(GetParam());
  expect_refused(required, Verdict::required, [&] { return smooth(required, VertexId(0)); });
  expect_refused(required, Verdict::not_needed, [&] { return relocate(required, VertexId(0)); });
  mesh.required_points.clear();
  KernelRig frozen(mesh, 1, kFaceted);
  frozen.judge_by(GetParam());
  frozen.mesh.freeze(VertexId(3));
  frozen.kernel.policy.frozen = FrozenPolicy::untouchable;
  expect_refused(frozen, Verdict::frozen, [&] { return smooth(frozen, VertexId(0)); });
  expect_refused(frozen, Verdict::frozen, [&] { return relocate(frozen, VertexId(0)); });
}

INSTANTIATE_TEST_SUITE_P(, MoveVertex, testing::Values(MetricMean::arithmetic, MetricMean::log_euclidean),
                         [](const auto& param_info) {
                           return param_info.param == MetricMean::arithmetic ? "arithmetic" : "log_euclidean";
                         });

}  // namespace
}  // namespace weft::meshing::operators_test

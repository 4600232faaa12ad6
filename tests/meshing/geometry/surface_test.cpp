// Tests of the reference geometry: classification by topology, and the curved surface by distance to the true
// one.
#include "meshing/geometry/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "meshing/base/error.h"

namespace weft::meshing::surface_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::uint32_t kNoHint = 0xFFFFFFFFu;

void add_triangle(MeshData& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::int32_t ref) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangle_refs.push_back(ref);
}

void add_quad(MeshData& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
              std::int32_t ref) {
  add_triangle(mesh, a, b, c, ref);
  add_triangle(mesh, a, c, d, ref);
}

/// Unit cube, outward triangles, one reference.
MeshData cube() {
  MeshData mesh;
  for (int i = 0; i < 8; ++i) mesh.points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
  add_quad(mesh, 0, 2, 3, 1, 1);
  add_quad(mesh, 4, 5, 7, 6, 1);
  add_quad(mesh, 0, 1, 5, 4, 1);
  add_quad(mesh, 2, 6, 7, 3, 1);
  add_quad(mesh, 0, 4, 6, 2, 1);
  add_quad(mesh, 1, 3, 7, 5, 1);
  return mesh;
}

/// n by m quads on the unit square in z = 0, each cut in two; vertex i + (n + 1) j.
MeshData square(int n, int m) {
  MeshData mesh;
  const auto id = [n](int i, int j) { return static_cast<std::uint32_t>(i + (n + 1) * j); };
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i) mesh.points.push_back({double(i) / n, double(j) / m, 0});
  }
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) add_quad(mesh, id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1), 1);
  }
  return mesh;
}

/// A frustum about z of radius 1 at z = 0 and 1 - taper * z above, height 2: mantle reference 1, caps 2
/// and 3. Vertices are shifted by up to `jitter` quarters of their distance, the diagonals random.
MeshData frustum(int around, int layers, double jitter = 0, double taper = 0) {
  MeshData mesh;
  std::mt19937 random(3);
  std::uniform_real_distribution<> shift(-0.25 * jitter, 0.25 * jitter);
  for (int j = 0; j <= layers; ++j) {
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * kPi * (i + shift(random)) / around;
      const double z = 2.0 / layers * (j + (j > 0 && j < layers ? shift(random) : 0));
      const double r = 1 - taper * z;
      mesh.points.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
  }
  const auto id = [around](int i, int j) { return static_cast<std::uint32_t>(j * around + i % around); };
  for (int j = 0; j < layers; ++j) {
    for (int i = 0; i < around; ++i) {
      if (random() % 2) {
        add_quad(mesh, id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1), 1);
      } else {
        add_quad(mesh, id(i + 1, j), id(i + 1, j + 1), id(i, j + 1), id(i, j), 1);
      }
    }
  }
  for (int i = 1; i + 1 < around; ++i) {
    add_triangle(mesh, id(0, 0), id(i + 1, 0), id(i, 0), 2);
    add_triangle(mesh, id(0, layers), id(i, layers), id(i + 1, layers), 3);
  }
  return mesh;
}

/// Unit sphere by latitude and longitude.
MeshData sphere(int bands, int around) {
  MeshData mesh;
  mesh.points.push_back({0, 0, 1});
  for (int j = 1; j < bands; ++j) {
    for (int i = 0; i < around; ++i) {
      const double t = kPi * j / bands, f = 2 * kPi * i / around;
      mesh.points.push_back({std::sin(t) * std::cos(f), std::sin(t) * std::sin(f), std::cos(t)});
    }
  }
  mesh.points.push_back({0, 0, -1});
  const auto last = static_cast<std::uint32_t>(mesh.points.size() - 1);
  const auto id = [around](int j, int i) {
    return static_cast<std::uint32_t>(1 + (j - 1) * around + i % around);
  };
  for (int i = 0; i < around; ++i) {
    add_triangle(mesh, 0, id(1, i), id(1, i + 1), 1);
    for (int j = 1; j + 1 < bands; ++j)
      add_quad(mesh, id(j, i), id(j + 1, i), id(j + 1, i + 1), id(j, i + 1), 1);
    add_triangle(mesh, last, id(bands - 1, i + 1), id(bands - 1, i), 1);
  }
  return mesh;
}

/// Cone of half-angle 45 degrees without its base; the tip is vertex 0, in the origin.
MeshData cone(int around) {
  MeshData mesh;
  mesh.points.push_back({0, 0, 0});
  for (int ring = 1; ring <= 2; ++ring) {
    for (int i = 0; i < around; ++i) {
      const double f = 2 * kPi * i / around;
      mesh.points.push_back({0.5 * ring * std::cos(f), 0.5 * ring * std::sin(f), 0.5 * ring});
    }
  }
  const auto id = [around](int ring, int i) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * around + i % around);
  };
  for (int i = 0; i < around; ++i) {
    add_triangle(mesh, 0, id(1, i), id(1, i + 1), 1);
    add_quad(mesh, id(1, i), id(2, i), id(2, i + 1), id(1, i + 1), 1);
  }
  return mesh;
}

void turn_some(MeshData& mesh) {
  std::mt19937 random(11);
  for (auto& t : mesh.triangles) {
    if (random() % 3 == 0) std::swap(t[1], t[2]);
  }
}

/// The name of a triangle of the mesh; kNoName for one of a plane.
std::uint32_t name_of(const MeshData& mesh, const Surface& surface, std::uint32_t triangle) {
  const auto& v = mesh.triangles[triangle];
  for (const auto& piece : surface.pieces().all())
    for (std::uint32_t i = 0; i < piece->triangles.size(); ++i)
      if (std::ranges::is_permutation(piece->triangle(i).vertices(), v)) return surface_name(piece->id, i);
  return kNoName;
}

std::size_t count_kind(const Surface& surface, const MeshData& mesh, VertexKind kind) {
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) count += surface.vertex_kind(v) == kind;
  return count;
}

/// A point of a flat triangle of the mesh, on its edges now and then.
struct Sample {
  std::uint32_t triangle;
  Point x;
};

std::vector<Sample> samples(const MeshData& mesh, int per_triangle) {
  std::mt19937 random(1);
  std::uniform_real_distribution<> unit(0, 1);
  std::vector<Sample> all;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    for (int i = 0; i < per_triangle; ++i) {
      double a = unit(random), b = i % 5 == 0 ? 0 : unit(random);
      if (a + b > 1) a = 1 - a, b = 1 - b;
      const Point& o = mesh.points[v[0]];
      all.push_back({t, o + a * (mesh.points[v[1]] - o) + b * (mesh.points[v[2]] - o)});
    }
  }
  return all;
}

/// Largest distance of the reconstructed curved patches from the true surface.
template <class Distance>
double deviation(const MeshData& mesh, const Distance& distance) {
  const Surface surface(mesh, {});
  double largest = 0;
  for (const Sample& s : samples(mesh, 30)) {
    const PatchId patch = surface.triangle_patch(s.triangle);
    if (surface.patches()[patch.value].planar) continue;
    largest = std::max(
        largest,
        std::abs(distance(
            surface.project_to_patch(patch, s.x, VertexKind::surface, name_of(mesh, surface, s.triangle))
                .x)));
  }
  return largest;
}

double off_cylinder(const Point& p) { return std::hypot(p.x, p.y) - 1; }
double off_sphere(const Point& p) { return norm(p) - 1; }

TEST(SurfaceTopology, CubeHasSixPlanesTwelveLinesEightCorners) {
  const MeshData mesh = cube();
  const Surface surface(mesh, {});
  ASSERT_EQ(surface.patches().size(), 6u);
  for (const Patch& p : surface.patches()) {
    EXPECT_TRUE(p.planar);
    // Exact, not just to rounding.
    EXPECT_EQ(std::abs(p.normal.x) + std::abs(p.normal.y) + std::abs(p.normal.z), 1);
    EXPECT_EQ(norm(p.normal), 1);
  }
  ASSERT_EQ(surface.curves().size(), 12u);
  for (const Curve& c : surface.curves()) EXPECT_TRUE(c.straight && !c.required);
  EXPECT_EQ(surface.feature_edges().size(), 12u);
  EXPECT_EQ(count_kind(surface, mesh, VertexKind::corner), 8u);
  EXPECT_EQ(surface.patches()[surface.triangle_patch(0).value].normal, (Vec{0, 0, -1}));
}

TEST(SurfaceTopology, ReferencesCutAFlatSide) {
  MeshData mesh = cube();
  mesh.triangle_refs[2] = 7;  // half of the side z = 1
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 7u);
  EXPECT_EQ(surface.curves().size(), 13u);
  EXPECT_EQ(surface.patches()[surface.triangle_patch(2).value].ref, 7);
  EXPECT_NE(surface.triangle_patch(2), surface.triangle_patch(3));
}

TEST(SurfaceTopology, OrientationsAreMadeToAgreeWithTheMajority) {
  MeshData mesh = frustum(18, 6);
  const Surface straight(mesh, {});
  turn_some(mesh);
  const Surface turned(mesh, {});
  ASSERT_EQ(turned.patches().size(), 3u);
  ASSERT_EQ(turned.curves().size(), 2u);
  for (const Sample& s : samples(mesh, 2)) {
    const auto a = straight.project_to_patch(straight.triangle_patch(s.triangle), s.x, VertexKind::surface,
                                             name_of(mesh, straight, s.triangle));
    const auto b = turned.project_to_patch(turned.triangle_patch(s.triangle), s.x, VertexKind::surface,
                                           name_of(mesh, turned, s.triangle));
    EXPECT_LT(norm(a.normal - b.normal), 1e-9);
    EXPECT_LT(norm(a.x - b.x), 1e-12);
  }
}

TEST(SurfaceTopology, CylinderHasTwoCurvesWithoutEnds) {
  const MeshData mesh = frustum(18, 3);
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 3u);
  ASSERT_EQ(surface.curves().size(), 2u);
  for (const Curve& c : surface.curves()) EXPECT_FALSE(c.straight);
  EXPECT_EQ(count_kind(surface, mesh, VertexKind::corner), 0u);
  EXPECT_EQ(count_kind(surface, mesh, VertexKind::ridge), 36u);
  EXPECT_EQ(count_kind(surface, mesh, VertexKind::surface), 36u);
}

TEST(SurfaceTopology, SphereHasNoFeatures) {
  const MeshData mesh = sphere(9, 18);
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 1u);
  EXPECT_FALSE(surface.patches()[0].planar);
  EXPECT_TRUE(surface.curves().empty());
  EXPECT_EQ(count_kind(surface, mesh, VertexKind::surface), mesh.points.size());
}

TEST(SurfaceTopology, DanglingRidgeEndsInCornersWithinOnePatch) {
  MeshData mesh = square(6, 6);
  for (std::uint32_t i = 0; i < 3; ++i) {
    mesh.edges.push_back({24 - i, 23 - i});  // from the middle vertex 24 to 21 on the border
    mesh.edge_refs.push_back(5);
  }
  mesh.ridges = {0, 1, 2};
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 1u);
  EXPECT_EQ(surface.vertex_kind(24), VertexKind::corner);
  EXPECT_EQ(surface.vertex_kind(23), VertexKind::ridge);
  EXPECT_EQ(surface.vertex_kind(21), VertexKind::corner);
  EXPECT_EQ(std::count_if(surface.curves().begin(), surface.curves().end(),
                          [](const Curve& c) { return c.ref == 5; }),
            1);
}

TEST(SurfaceTopology, EdgesOfThreeTrianglesAreFeatures) {
  // Two unit cubes side by side and the side they share.
  MeshData mesh = cube();
  for (int i : {1, 3, 5, 7}) mesh.points.push_back(mesh.points[i] + Vec{1, 0, 0});  // 8..11
  add_quad(mesh, 1, 3, 9, 8, 1);
  add_quad(mesh, 5, 10, 11, 7, 1);
  add_quad(mesh, 1, 8, 10, 5, 1);
  add_quad(mesh, 3, 7, 11, 9, 1);
  add_quad(mesh, 8, 9, 11, 10, 1);
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 11u);
  EXPECT_EQ(surface.curves().size(), 20u);
  EXPECT_EQ(count_kind(surface, mesh, VertexKind::corner), 12u);
}

TEST(SurfaceTopology, SurfacesThatTouchInAVertexHaveACornerThere) {
  MeshData mesh = sphere(9, 18), other = mesh;
  const auto n = static_cast<std::uint32_t>(mesh.points.size());
  for (const Point& p : other.points) mesh.points.push_back(p + Vec{0, 0, 2});
  for (auto t : other.triangles) {
    for (auto& v : t) v = v == n - 1 ? 0 : v + n;  // its south pole on the first one's north pole
    add_triangle(mesh, t[0], t[1], t[2], 1);
  }
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 2u);
  EXPECT_EQ(surface.vertex_kind(0), VertexKind::corner);
  EXPECT_EQ(surface.vertex_kind(2 * n - 1), VertexKind::interior);
}

TEST(SurfaceTopology, RequiredEntitiesAreKept) {
  MeshData mesh = square(4, 4);
  mesh.edges = {{6, 7}, {7, 8}};
  mesh.edge_refs = {0, 0};
  mesh.required_edges = {0, 1};
  mesh.required_points = {18};
  mesh.required_triangles = {31};
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.vertex_kind(18), VertexKind::corner);
  EXPECT_EQ(surface.vertex_kind(7), VertexKind::ridge);
  EXPECT_EQ(surface.vertex_kind(6), VertexKind::corner);
  EXPECT_EQ(surface.patches().size(), 2u);
  std::size_t required = 0;
  for (const auto& e : surface.feature_edges()) required += surface.curves()[e.curve.value].required;
  EXPECT_EQ(required, 5u);
}

TEST(SurfaceTopology, HintsNameWhatTheKindSays) {
  const MeshData mesh = frustum(12, 2);
  const Surface surface(mesh, {});
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    const std::uint32_t hint = surface.vertex_hint(v);
    if (surface.vertex_kind(v) == VertexKind::surface) {
      const TriangleView triangle = surface.pieces().triangle(hint);
      ASSERT_TRUE(triangle);
      EXPECT_EQ(std::ranges::count(triangle.vertices(), v), 1);
    } else {
      const SurfaceFeature* edge = surface.pieces().feature(hint);
      ASSERT_NE(edge, nullptr);
      EXPECT_TRUE(edge->vertices[0] == v || edge->vertices[1] == v);
    }
  }
}

TEST(SurfaceTopology, RefusesIndicesOutOfRange) {
  MeshData mesh = cube();
  mesh.triangles[3][1] = 8;
  EXPECT_THROW(Surface(mesh, {}), InputError);
  mesh.triangles[3][1] = mesh.triangles[3][0];
  EXPECT_THROW(Surface(mesh, {}), InputError);
}

TEST(SurfacePlane, PointsOfThePlaneComeBackUnchanged) {
  const Surface surface(cube(), {});
  const PatchId top = surface.triangle_patch(2);
  const Point p{0.3, 1.7, 1};  // beyond the patch's border too
  EXPECT_EQ(surface.project_to_patch(top, p, VertexKind::surface, 2).x, p);
  const auto above = surface.project_to_patch(top, {0.3, 0.1, 1.25}, VertexKind::interior, kNoHint);
  EXPECT_EQ(above.x, (Point{0.3, 0.1, 1}));
  EXPECT_EQ(above.normal, (Vec{0, 0, 1}));
}

TEST(SurfacePlane, StraightCurvesKeepPointsAndWalkTheirHint) {
  MeshData mesh = square(8, 4);
  for (Point& p : mesh.points) p = {p.x, std::sin(p.y), 1 - std::cos(p.y)};  // of a cylinder
  const Surface surface(mesh, {});
  const std::uint32_t first = surface.vertex_hint(1);
  ASSERT_NE(surface.pieces().feature(first), nullptr);
  const CurveId bottom = surface.pieces().feature(first)->curve;
  ASSERT_TRUE(surface.curves()[bottom.value].straight);
  const auto on = surface.project_to_curve(bottom, {0.7, 0, 0}, VertexKind::ridge, first);
  EXPECT_EQ(on.x, (Point{0.7, 0, 0}));
  EXPECT_EQ(surface.pieces().feature(on.hint)->vertices, (std::array<std::uint32_t, 2>{5, 6}));
  const auto off =
      surface.project_to_curve(bottom, {0.7, 0.2, 0.1}, VertexKind::corner, surface.vertex_hint(0));
  EXPECT_EQ(off.x, (Point{0.7, 0, 0}));
  EXPECT_EQ(std::abs(off.tangent.x), 1);
}

TEST(SurfacePlane, TakesNoPieces) {
  const Surface surface(cube(), {});
  EXPECT_TRUE(surface.pieces().all().empty());
  EXPECT_EQ(surface.vertex_hint(0), kNoName);
}

TEST(SurfaceShape, CylinderIsMetFarBetterThanByItsFacets) {
  EXPECT_LT(deviation(frustum(18, 1), off_cylinder), 2e-5);  // facets: 1.5e-2
  EXPECT_LT(deviation(frustum(18, 4), off_cylinder), 2e-5);
  EXPECT_LT(deviation(frustum(18, 6, 1), off_cylinder), 2e-3);
}

TEST(SurfaceShape, SphereAndConeAreMetFarBetterThanByTheirFacets) {
  EXPECT_LT(deviation(sphere(9, 18), off_sphere), 3e-4);     // facets: 3e-2
  EXPECT_LT(deviation(sphere(18, 36), off_sphere), 1.5e-5);  // facets: 8e-3
  const double taper = 0.3, cosine = 1 / std::hypot(1, taper);
  const auto off = [&](const Point& p) { return (std::hypot(p.x, p.y) - 1 + taper * p.z) * cosine; };
  EXPECT_LT(deviation(frustum(18, 6, 0, taper), off), 2e-3);  // facets: 1.5e-2
}

TEST(SurfaceShape, TipOfAConeIsACornerAndNotRounded) {
  const MeshData mesh = cone(24);
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.vertex_kind(0), VertexKind::corner);
  EXPECT_EQ(surface.vertex_kind(1), VertexKind::surface);
  const auto off = [](const Point& p) { return (std::hypot(p.x, p.y) - p.z) / std::sqrt(2); };
  EXPECT_LT(deviation(mesh, off), 2e-3);  // facets: 6e-3
}

TEST(SurfaceShape, NormalsAreUnitAndNearlyTrue) {
  const MeshData mesh = frustum(18, 4);
  const Surface surface(mesh, {});
  for (const Sample& s : samples(mesh, 10)) {
    const PatchId patch = surface.triangle_patch(s.triangle);
    if (surface.patches()[patch.value].planar) continue;
    const auto q =
        surface.project_to_patch(patch, s.x, VertexKind::surface, name_of(mesh, surface, s.triangle));
    const double r = std::hypot(q.x.x, q.x.y);
    EXPECT_NEAR(norm(q.normal), 1, 1e-14);
    EXPECT_LT(norm(q.normal - Vec{q.x.x / r, q.x.y / r, 0}), 2e-3);
  }
}

TEST(SurfaceShape, CurvesMeetTheCircleAndStayInTheirPlane) {
  const MeshData mesh = frustum(18, 2);
  const Surface surface(mesh, {});
  for (std::uint32_t f = 0; f < surface.feature_edges().size(); ++f) {
    const auto& e = surface.feature_edges()[f];
    const Point &a = mesh.points[e.vertices[0]], &b = mesh.points[e.vertices[1]];
    for (double s : {0.0, 0.2, 0.5, 0.9}) {
      const std::uint32_t near = surface.vertex_hint(e.vertices[0]);
      const auto q = surface.project_to_curve(e.curve, a + s * (b - a), VertexKind::ridge, near);
      EXPECT_NEAR(std::hypot(q.x.x, q.x.y), 1, 1e-7);
      EXPECT_EQ(q.x.z, a.z);
      EXPECT_EQ(q.tangent.z, 0);
    }
  }
}

TEST(SurfaceShape, PatchesMeetInTheirCurveWithoutAGap) {
  const MeshData mesh = frustum(18, 2);
  const Surface surface(mesh, {});
  const PatchId mantle = surface.triangle_patch(0);
  for (std::uint32_t f = 0; f < surface.feature_edges().size(); ++f) {
    const auto& e = surface.feature_edges()[f];
    const Point p = midpoint(mesh.points[e.vertices[0]], mesh.points[e.vertices[1]]);
    const std::uint32_t near = surface.vertex_hint(e.vertices[0]);
    const auto on_curve = surface.project_to_curve(e.curve, p, VertexKind::ridge, near);
    const auto on_patch = surface.project_to_patch(mantle, on_curve.x, VertexKind::ridge, on_curve.hint);
    EXPECT_LT(norm(on_curve.x - on_patch.x), 1e-14);
  }
}

TEST(SurfaceShape, ProjectionIsContinuousAcrossTriangleEdges) {
  const MeshData mesh = sphere(9, 18);
  const Surface surface(mesh, {});
  const double step = 1e-10;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    const Point a = mesh.points[v[0]], b = mesh.points[v[1]], c = mesh.points[v[2]];
    const std::uint32_t name = name_of(mesh, surface, t);
    const Point edge = surface.project_to_patch(PatchId(0), a + 0.3 * (b - a), VertexKind::surface, name).x;
    const Vec inward = step * (c - edge);
    const auto in = surface.project_to_patch(PatchId(0), edge + inward, VertexKind::surface, name);
    const auto out = surface.project_to_patch(PatchId(0), edge - inward, VertexKind::surface, name);
    EXPECT_LT(norm(in.x - out.x), 10 * step);
  }
}

TEST(SurfaceWalk, AgreesWithTheGlobalSearch) {
  for (const MeshData& mesh : {frustum(18, 6, 1), sphere(9, 18)}) {
    const Surface surface(mesh, {});
    for (const Sample& s : samples(mesh, 5)) {
      const PatchId patch = surface.triangle_patch(s.triangle);
      const auto global = surface.project_to_patch(patch, s.x, VertexKind::interior, kNoHint);
      for (std::uint32_t v : mesh.triangles[s.triangle]) {
        const auto near =
            surface.project_to_patch(patch, s.x, surface.vertex_kind(v), surface.vertex_hint(v));
        // From a point halfway between two closest points either may be found.
        EXPECT_NEAR(norm(near.x - s.x), norm(global.x - s.x), 1e-12);
      }
    }
  }
}

TEST(SurfaceWalk, FindsItsWayAlongACurve) {
  const MeshData mesh = frustum(40, 1);
  const Surface surface(mesh, {});
  const CurveId bottom = surface.pieces().feature(surface.vertex_hint(0))->curve;
  for (int i = 0; i < 100; ++i) {
    const double f = 2 * kPi * (i + 0.3) / 100;
    const Point p{1.1 * std::cos(f), 1.1 * std::sin(f), 0.1};
    const auto global = surface.project_to_curve(bottom, p, VertexKind::interior, kNoHint);
    EXPECT_LT(norm(global.x - Point{std::cos(f), std::sin(f), 0}), 1e-7);
    const auto near = surface.project_to_curve(bottom, p, VertexKind::ridge, global.hint);
    EXPECT_LT(norm(near.x - global.x), 1e-14);
    // From a quarter of the way around.
    const auto start = static_cast<std::uint32_t>((i * 40 / 100 + 10) % 40);
    const auto far = surface.project_to_curve(bottom, p, VertexKind::ridge, surface.vertex_hint(start));
    EXPECT_LT(norm(far.x - global.x), 1e-12);
  }
}

TEST(SurfaceWalk, HintsOfOtherPatchesFallBackToTheGlobalSearch) {
  const MeshData mesh = frustum(18, 3);
  const Surface surface(mesh, {});
  const PatchId mantle = surface.triangle_patch(0);
  const auto cap = static_cast<std::uint32_t>(mesh.triangles.size() - 1);
  ASSERT_NE(surface.triangle_patch(cap), mantle);
  const auto q = surface.project_to_patch(mantle, {0, 0.9, 1.1}, VertexKind::surface, cap);
  EXPECT_LT(norm(q.x - Point{0, 1, 1.1}), 1e-4);
  EXPECT_EQ(surface.pieces().triangle(q.hint).patch(), mantle);
}

TEST(SurfaceDegenerate, TrianglesWithoutAreaGiveNumbers) {
  MeshData mesh = frustum(18, 2);
  // Cut the edge of a mantle triangle and its neighbour by a sliver whose vertices are in line.
  const auto [a, b, c] = mesh.triangles[0];
  mesh.points.push_back(midpoint(mesh.points[a], mesh.points[b]));
  const auto m = static_cast<std::uint32_t>(mesh.points.size() - 1);
  mesh.triangles[0] = {a, m, c};
  add_triangle(mesh, m, b, c, 1);
  add_triangle(mesh, a, b, m, 1);
  const Surface surface(mesh, {});
  for (const Sample& s : samples(mesh, 5)) {
    const PatchId patch = surface.triangle_patch(s.triangle);
    const auto q = surface.project_to_patch(patch, s.x + Vec{1e-3, 0, 0}, VertexKind::surface,
                                            name_of(mesh, surface, s.triangle));
    EXPECT_TRUE(std::isfinite(norm(q.x)));
    EXPECT_NEAR(norm(q.normal), 1, 1e-12);
  }
}

TEST(SurfaceDegenerate, RidgeRunsAlongTheRightSideOfATriangleWithoutArea) {
  MeshData mesh = cube();
  // The edge 2-3 of the bottom gets a midpoint there, but not on the side y = 1: a sliver closes the gap.
  mesh.points.push_back({0.5, 1, 0});
  mesh.triangles[0] = {0, 2, 8};
  add_triangle(mesh, 0, 8, 3, 1);
  add_triangle(mesh, 2, 3, 8, 1);
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 6u);
  EXPECT_EQ(surface.vertex_kind(8), VertexKind::ridge);
}

TEST(SurfaceDegenerate, NonOrientableStripIsBuilt) {
  MeshData mesh;
  const int n = 30;
  for (int i = 0; i < n; ++i) {
    const double f = 2 * kPi * i / n;
    for (double w : {-0.3, 0.3}) {
      const double r = 1 + w * std::cos(f / 2);
      mesh.points.push_back({r * std::cos(f), r * std::sin(f), w * std::sin(f / 2)});
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool wrap = i + 1 == n;
    const std::uint32_t c = wrap ? 1 : 2 * i + 2, d = wrap ? 0 : 2 * i + 3;
    add_quad(mesh, 2 * i, 2 * i + 1, d, c, 1);
  }
  const Surface surface(mesh, {});
  EXPECT_EQ(surface.patches().size(), 1u);
  for (const Sample& s : samples(mesh, 3)) {
    EXPECT_NEAR(
        norm(
            surface.project_to_patch(PatchId(0), s.x, VertexKind::surface, name_of(mesh, surface, s.triangle))
                .normal),
        1, 1e-12);
  }
}

TEST(SurfaceThreads, QueriesMayRunTogether) {
  const MeshData mesh = frustum(36, 8, 1);
  const Surface surface(mesh, {});
  const auto points = samples(mesh, 10);
  const auto project_all = [&] {
    std::vector<Point> result;
    for (const Sample& s : points) {
      const PatchId patch = surface.triangle_patch(s.triangle);
      const bool hinted = result.size() % 2 == 0;
      result.push_back(surface
                           .project_to_patch(patch, s.x, hinted ? VertexKind::surface : VertexKind::interior,
                                             hinted ? name_of(mesh, surface, s.triangle) : kNoHint)
                           .x);
    }
    return result;
  };
  const auto expected = project_all();
  std::vector<std::vector<Point>> results(4);
  std::vector<std::thread> threads;
  for (auto& r : results) threads.emplace_back([&] { r = project_all(); });
  for (auto& t : threads) t.join();
  for (const auto& r : results) EXPECT_EQ(r, expected);
}

TEST(Surface, OfAMeshWithoutTrianglesIsEmpty) {
  const Surface surface(MeshData{}, {});
  EXPECT_TRUE(surface.patches().empty());
  EXPECT_TRUE(surface.curves().empty());
}

}  // namespace
}  // namespace weft::meshing::surface_test

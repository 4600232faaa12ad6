// Parts of a surface against the whole.
#include "meshing/geometry/surface_piece.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "meshing/geometry/surface.h"
#include "tests/support/meshes.h"

namespace weft::meshing::surface_piece_test {
namespace {

using Piece = SurfacePieces::Piece;

/// Some thousand triangles: a cylinder, or a ball with bumps, in no order.
MeshData body(unsigned seed) {
  MeshData mesh = seed % 2 ? support::cylinder(60, 1, 30, 2) : support::ball(4, 1);
  for (Point& p : mesh.points)
    if (seed % 2 == 0) p = (1 + 0.05 * std::sin(7 * p.x + seed) * std::cos(5 * p.y)) * p;
  support::shuffle(mesh, seed);
  return mesh;
}

bool same(const Point& a, const Point& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

double diameter(const SurfaceTriangle& t) { return norm(t.box().size()); }

/// The pieces that come nearer to a piece than `distance`.
SurfacePieces around(const Surface& whole, const Piece& core, double distance) {
  SurfacePieces near;
  for (const Piece& piece : whole.pieces().all()) {
    bool meets = true;
    for (int i = 0; i < 3; ++i)
      meets = meets && piece->box.lo[i] <= core->box.hi[i] + distance &&
              core->box.lo[i] - distance <= piece->box.hi[i];
    if (meets) near.add({&piece, 1});
  }
  return near;
}

TEST(SurfacePieces, HaveEachCurvedTriangleAndItsNeighboursByName) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const MeshData mesh = body(seed);
    const Surface surface(mesh, {});
    const SurfacePieces& pieces = surface.pieces();
    EXPECT_GE(pieces.all().size(), 5u);
    std::vector<int> seen(mesh.triangles.size(), 0);
    for (const Piece& piece : pieces.all()) {
      EXPECT_LE(std::max(piece->triangles.size(), piece->features.size()), kSurfacePieceSize);
      for (std::uint32_t i = 0; i < piece->triangles.size(); ++i) {
        const SurfaceTriangle& t = piece->triangles[i];
        ++seen[t.number];
        EXPECT_EQ(t.patch, surface.triangle_patch(t.number));
        for (const std::uint32_t n : t.neighbours) {
          if (n == kNoName) continue;
          ASSERT_NE(pieces.triangle(n), nullptr);
          EXPECT_EQ(std::ranges::count(pieces.triangle(n)->neighbours, surface_name(piece->id, i)), 1);
        }
      }
      for (std::uint32_t i = 0; i < piece->features.size(); ++i) {
        const SurfaceFeature& f = piece->features[i];
        if (f.next != kNoName) {
          EXPECT_EQ(pieces.feature(f.next)->previous, surface_name(piece->id, i));
        }
      }
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      EXPECT_EQ(seen[t], surface.patches()[surface.triangle_patch(t).value].planar ? 0 : 1);
  }
}

/// From points beside a piece's triangles: closest points, normals and hints have the bits of the whole
/// surface's.
TEST(SurfacePieces, APartAnswersAsTheWholeWhereItsPiecesReach) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Surface whole(body(seed), {});
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-0.4, 0.4);
    std::size_t fewer = 0;
    for (const Piece& core : whole.pieces().all()) {
      double reach = 0;
      for (const SurfaceTriangle& t : core->triangles) reach = std::max(reach, diameter(t));
      for (const SurfaceFeature& f : core->features) reach = std::max(reach, norm(f.ends[1] - f.ends[0]));
      const Surface part = whole.part(around(whole, core, reach));
      fewer += part.pieces().all().size() < whole.pieces().all().size() * 2 / 3;
      for (std::uint32_t i = 0; i < core->triangles.size(); ++i) {
        const SurfaceTriangle& t = core->triangles[i];
        const double size = diameter(t);
        const Point p = t.corners[i % 3] + size * Vec{u(random), u(random), u(random)};
        const std::uint32_t hint = surface_name(core->id, i);
        const auto a = whole.project_to_patch(t.patch, p, VertexKind::surface, hint);
        const auto b = part.project_to_patch(t.patch, p, VertexKind::surface, hint);
        EXPECT_TRUE(same(a.x, b.x) && same(a.normal, b.normal) && a.hint == b.hint);
      }
      for (std::uint32_t i = 0; i < core->features.size(); ++i) {
        const SurfaceFeature& f = core->features[i];
        const Point p = f.ends[i % 2] + reach * Vec{u(random), u(random), u(random)};
        const std::uint32_t hint = surface_name(core->id, i);
        const auto a = whole.project_to_curve(f.curve, p, VertexKind::ridge, hint);
        const auto b = part.project_to_curve(f.curve, p, VertexKind::ridge, hint);
        EXPECT_TRUE(same(a.x, b.x) && same(a.tangent, b.tangent) && a.hint == b.hint);
      }
    }
    EXPECT_GT(fewer, whole.pieces().all().size() / 3) << "parts are parts";
  }
}

TEST(SurfacePieces, AWalkEndsWhereTheyDo) {
  const Surface whole(body(0), {});
  const Piece& first = whole.pieces().all().front();
  SurfacePieces one;
  one.add({&first, 1});
  const Surface part = whole.part(one);
  const std::uint32_t hint = surface_name(first->id, 0);
  const Point p = -1.0 * first->triangles[0].corners[0];  // on the other side
  const auto q = part.project_to_patch(PatchId(0), p, VertexKind::surface, hint);
  EXPECT_EQ(piece_of_name(q.hint), first->id);
  EXPECT_NE(piece_of_name(whole.project_to_patch(PatchId(0), p, VertexKind::surface, hint).hint), first->id);
  EXPECT_NEAR(norm(q.normal), 1, 1e-12);
}

TEST(SurfacePieces, WhatIsNotHereHasNoNormal) {
  const Surface whole(body(1), {});
  const Surface none = whole.part({});
  EXPECT_EQ(none.patches().size(), whole.patches().size());
  EXPECT_EQ(none.curves().size(), whole.curves().size());
  const SurfaceTriangle& t = whole.pieces().all().front()->triangles[0];
  const auto on_patch = none.project_to_patch(t.patch, t.corners[0], VertexKind::surface, 0);
  EXPECT_EQ(on_patch.x, t.corners[0]);
  EXPECT_EQ(on_patch.normal, Vec{});
  EXPECT_EQ(on_patch.hint, kNoName);
  const SurfaceFeature& f = whole.pieces().all().back()->features[0];
  const auto on_curve = none.project_to_curve(f.curve, f.ends[0], VertexKind::ridge, 0);
  EXPECT_EQ(on_curve.x, f.ends[0]);
  EXPECT_EQ(on_curve.tangent, Vec{});
}

TEST(SurfacePieces, AreTakenOnceAndFoundInAnyOrder) {
  const Surface whole(body(0), {});
  const auto all = whole.pieces().all();
  SurfacePieces some;
  for (std::size_t i = all.size(); i-- > 1;) some.add({&all[i], 1});
  some.add(all.subspan(1));
  EXPECT_EQ(some.all().size(), all.size() - 1);
  EXPECT_FALSE(some.has(all[0]->id));
  EXPECT_EQ(some.triangle(surface_name(all[0]->id, 0)), nullptr);
  SurfacePieces copy = some;
  copy.add(all.first(1));
  EXPECT_TRUE(copy.has(all[0]->id));
  EXPECT_FALSE(some.has(all[0]->id)) << "a copy is its own";
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(copy.all()[i], all[i]);
}

}  // namespace
}  // namespace weft::meshing::surface_piece_test

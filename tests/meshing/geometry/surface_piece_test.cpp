// Parts of a surface against the whole.
#include "meshing/geometry/surface/surface_piece.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <vector>

#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_tables.h"
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

double diameter(const TriangleView& t) { return norm(t.box().size()); }

std::array<std::uint32_t, 3> sorted(std::array<std::uint32_t, 3> v) {
  std::ranges::sort(v);
  return v;
}

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
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> number_of;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) number_of[sorted(mesh.triangles[t])] = t;
    std::vector<int> seen(mesh.triangles.size(), 0);
    for (const Piece& piece : pieces.all()) {
      EXPECT_LE(std::max(piece->triangles.size(), piece->features.size()), kSurfacePieceSize);
      for (std::uint32_t i = 0; i < piece->triangles.size(); ++i) {
        const TriangleView t = piece->triangle(i);
        const std::uint32_t number = number_of.at(sorted(t.vertices()));
        ++seen[number];
        EXPECT_EQ(t.patch(), surface.triangle_patch(number));
        for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(same(t.corner(k), mesh.points[t.vertices()[k]]));
        for (const std::uint32_t n : t.neighbours()) {
          if (n == kNoName) continue;
          ASSERT_TRUE(pieces.triangle(n));
          EXPECT_EQ(std::ranges::count(pieces.triangle(n).neighbours(), surface_name(piece->id, i)), 1);
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
      for (std::size_t i = 0; i < core->triangles.size(); ++i)
        reach = std::max(reach, diameter(core->triangle(i)));
      for (const SurfaceFeature& f : core->features) reach = std::max(reach, norm(f.ends[1] - f.ends[0]));
      const Surface part = whole.part(around(whole, core, reach));
      fewer += part.pieces().all().size() < whole.pieces().all().size() * 2 / 3;
      for (std::uint32_t i = 0; i < core->triangles.size(); ++i) {
        const TriangleView t = core->triangle(i);
        const double size = diameter(t);
        const Point p = t.corner(i % 3) + size * Vec{u(random), u(random), u(random)};
        const std::uint32_t hint = surface_name(core->id, i);
        const auto a = whole.project_to_patch(t.patch(), p, VertexKind::surface, hint);
        const auto b = part.project_to_patch(t.patch(), p, VertexKind::surface, hint);
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
  const Point p = -1.0 * first->triangle(0).corner(0);  // on the other side
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
  const TriangleView t = whole.pieces().all().front()->triangle(0);
  const auto on_patch = none.project_to_patch(t.patch(), t.corner(0), VertexKind::surface, 0);
  EXPECT_EQ(on_patch.x, t.corner(0));
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
  EXPECT_FALSE(some.triangle(surface_name(all[0]->id, 0)));
  SurfacePieces copy = some;
  copy.add(all.first(1));
  EXPECT_TRUE(copy.has(all[0]->id));
  EXPECT_FALSE(some.has(all[0]->id)) << "a copy is its own";
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(copy.all()[i], all[i]);
}

/// Pieces made later, in any order, are those that a surface has at once.
TEST(SurfacePieces, AreTheSameWhenTheyAreMadeLater) {
  for (unsigned seed = 0; seed < 2; ++seed) {
    const MeshData mesh = body(seed);
    const Surface at_once(mesh, {});
    const BuiltSurface later = build_surface(mesh, {}, {});
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
      EXPECT_EQ(later.input.vertex_kind[v], at_once.vertex_kind(v));
      EXPECT_EQ(later.input.vertex_hint[v], at_once.vertex_hint(v));
    }
    const std::vector<std::uint32_t> ids = later.cutter->ids();
    ASSERT_EQ(ids.size(), at_once.pieces().all().size());
    for (std::size_t i = ids.size(); i-- > 0;) {
      const Piece piece = later.cutter->piece(ids[i]), &expected = at_once.pieces().all()[i];
      EXPECT_TRUE(std::ranges::equal(piece->bytes(), expected->bytes()));
      EXPECT_EQ(later.cutter->box(ids[i]).lo, expected->box.lo);
      EXPECT_EQ(later.cutter->box(ids[i]).hi, expected->box.hi);
    }
    const Surface of_tables(later.tables);
    EXPECT_TRUE(of_tables.pieces().all().empty());
    EXPECT_EQ(of_tables.patches().size(), at_once.patches().size());
    EXPECT_EQ(of_tables.curves().size(), at_once.curves().size());
  }
}

TEST(SurfacePieces, AreReadFromTheirBytesAndRefuseOthers) {
  const Surface surface(body(1), {});
  for (const Piece& piece : surface.pieces().all()) {
    const SurfacePiece again(piece->bytes(), piece->owner());
    EXPECT_EQ(again.id, piece->id);
    EXPECT_EQ(again.points.data(), piece->points.data()) << "nothing is copied";
    EXPECT_EQ(again.triangles.size(), piece->triangles.size());
    for (const std::size_t size : {std::size_t{0}, std::size_t{64}, piece->bytes().size() - 8})
      EXPECT_THROW(SurfacePiece(piece->bytes().first(size), piece->owner()), std::runtime_error);
  }
}

/// A patch in pieces takes fewer bytes than 212 a triangle, which the arrays of a whole one took.
TEST(SurfacePieces, AreSmall) {
  const Surface surface(body(0), {});
  std::size_t bytes = 0, triangles = 0;
  for (const Piece& piece : surface.pieces().all()) {
    bytes += piece->bytes().size();
    triangles += piece->triangles.size();
  }
  EXPECT_LT(bytes, 170 * triangles);
}

}  // namespace
}  // namespace weft::meshing::surface_piece_test

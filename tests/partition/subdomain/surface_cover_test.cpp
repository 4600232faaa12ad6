// What subdomains have of the surface is enough: they do the same with all of it.
#include "partition/subdomain/surface_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "tests/partition/scenes.h"
#include "tests/partition/shift/rounds.h"
#include "tests/support/repetitions.h"

namespace weft::partition::surface_cover_test {
namespace {

using namespace weft::support;

/// Curved bodies whose surface has several pieces, cut into slabs.
Scene curved_scene(unsigned seed) {
  Scene scene;
  scene.curved = true;
  scene.mesh = seed % 2 ? cylinder(64, 1, 24, 2) : ball(4, 1);
  for (Point& p : scene.mesh.points)
    if (seed % 2 == 0) p = (1 + 0.04 * std::sin(5 * p.x) * std::cos(4 * p.y)) * p;
  shuffle(scene.mesh, seed);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.16, seed);
  cut_at_random(scene, 5, 1, seed);
  return scene;
}

Cut with_all_pieces(Cut cut) {
  const auto all = cut.geometry.surface.pieces().all();
  for (SubdomainStart& s : cut.starts) s.surface.assign(all.begin(), all.end());
  return cut;
}

void expect_same(const Rounds& a, const Rounds& b) {
  const auto x = a.pieces(), y = b.pieces();
  for (std::size_t s = 0; s < x.size(); ++s) {
    ASSERT_EQ(x[s].mesh.tets, y[s].mesh.tets);
    EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(x[s].mesh.points)),
                                   std::as_bytes(std::span(y[s].mesh.points))));
  }
}

std::size_t pieces_in(Rounds& rounds) {
  std::size_t sum = 0;
  for (const Subdomain& s : rounds.subdomains()) sum += s.surface.all().size();
  return sum;
}

TEST(SurfaceCover, AdaptationsAndShiftsAskForNothingElse) {
  for (unsigned seed = 0; seed < repetitions(1, 2); ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene = curved_scene(seed);
    const Cut cut = scene.cut(), whole = with_all_pieces(scene.cut());
    Rounds covered(cut, scene.hausd(), {2, false}), all(whole, scene.hausd(), {2, false});
    EXPECT_LT(pieces_in(covered), pieces_in(all) * 3 / 4);
    const auto both = [&](auto step) {
      step(covered), step(all);
      expect_same(covered, all);
    };
    both([](Rounds& r) { r.adapt_interiors(); });
    for (unsigned round = 0; round < 2 && !HasFatalFailure(); ++round) {
      std::mt19937 random(round);
      const auto priorities = random_priorities(scene.subdomains, random);
      both([&](Rounds& r) { r.shift(priorities); });
      both([](Rounds& r) { r.adapt(meshing::Extent::fresh); });
      both([](Rounds& r) { EXPECT_EQ(r.update(), 0); });
    }
    EXPECT_LT(pieces_in(covered), pieces_in(all)) << "shifts bring what is near alone";
  }
}

/// After shifts, every vertex has the piece that its hint names.
TEST(SurfaceCover, HintsTravelWithTheirPieces) {
  const Scene scene = curved_scene(2);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {2, false});
  std::mt19937 random(1);
  for (int round = 0; round < 3; ++round) {
    rounds.shift(random_priorities(scene.subdomains, random));
    rounds.update();
    std::size_t named = 0;
    for (const Subdomain& s : rounds.subdomains())
      for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i) {
        const meshing::VertexId v(i);
        if (!s.mesh->alive(v) || s.mesh->surface_hint(v) == meshing::kNoName) continue;
        ++named;
        EXPECT_NE(s.surface.piece_of(s.mesh->surface_hint(v)), nullptr);
      }
    EXPECT_GT(named, 1000u);
  }
}

TEST(SurfaceCover, WhoDividesKeepsWhatIsNear) {
  Scene scene = curved_scene(0);
  scene.subdomains = 4;
  scene.part.assign(scene.mesh.tets.size(), SubdomainId(0));
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {2, false});
  const std::size_t all = rounds.subdomains()[0].surface.all().size();
  EXPECT_EQ(all, cut.geometry.surface.pieces().all().size());
  rounds.divide({4, 0, 0, 0});
  rounds.update();
  for (const Subdomain& s : rounds.subdomains()) {
    EXPECT_GT(s.surface.all().size(), 0u);
    EXPECT_LT(s.surface.all().size(), all * 3 / 4);
  }
}

TEST(SharedPieces, SurfaceIsOnceOnARank) {
  const meshing::Surface surface(ball(4, 1), {});
  const auto copies = [&](std::size_t first, std::size_t count) {
    meshing::SurfacePieces pieces;
    for (const auto& piece : surface.pieces().all().subspan(first, count)) {
      const auto copy = std::make_shared<const meshing::SurfacePiece>(*piece);
      pieces.add({&copy, 1});
    }
    return pieces;
  };
  SharedPieces<meshing::SurfacePiece> shared;
  meshing::SurfacePieces a = copies(0, 6), b = copies(4, 6);
  for (auto* pieces : {&a, &b}) share_surface(*pieces, shared);
  EXPECT_EQ(a.all().size(), 6u);
  EXPECT_EQ(b.all().size(), 6u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(a.all()[4 + i], b.all()[i]);
  EXPECT_EQ(b.piece_of(meshing::surface_name(4, 0)), a.all()[4].get());
  a = b = {};
  meshing::SurfacePieces c = copies(0, 1);
  share_surface(c, shared);
  EXPECT_EQ(c.all().size(), 1u) << "those that nobody has any more are gone";
}

/// A face far away that lies in a plane asks for nothing, however large it is.
TEST(SurfaceCover, PlanarFacesTakeNothing) {
  const meshing::Surface surface(ball(4, 1), {});
  const auto on_ball = surface.pieces().all().front()->triangle(0).corner(0);
  SurfaceCover nothing;
  nothing.add_face({{0, 0, 10}, meshing::kNoName}, {{20, 0, 10}, meshing::kNoName}, {on_ball, 0});
  nothing.finish();
  EXPECT_TRUE(nothing.pieces(surface.pieces()).empty());
  SurfaceCover one;
  one.add({on_ball, meshing::surface_name(0, 0)});
  one.finish();
  ASSERT_EQ(one.pieces(surface.pieces()).size(), 1u);
  EXPECT_EQ(one.pieces(surface.pieces())[0]->id, 0u);
}

}  // namespace
}  // namespace weft::partition::surface_cover_test

// A subdomain that has travelled is the one that left: whatever is done with it afterwards gives the same
// bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "engine/base/serialize.h"
#include "partition/shift/shift.h"
#include "partition/subdomain/adapt_subdomain.h"
#include "partition/subdomain/subdomain.h"
#include "tests/partition/scenes.h"
#include "tests/partition/shift/rounds.h"
#include "tests/support/repetitions.h"

namespace weft::graph::adaptation::subdomain_serialize_test {
namespace {

using namespace weft::support;
using partition::BackgroundStore;
using partition::Subdomain;

Subdomain travelled(Subdomain& s) {
  engine::Packer packer;
  packer(s);
  engine::Unpacker unpacker(packer.take());
  Subdomain arrived;
  unpacker(arrived);
  unpacker.finish();
  return arrived;
}

bool same_bits(const meshing::Point& a, const meshing::Point& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

void expect_same_background(const BackgroundStore& a, const BackgroundStore& b) {
  const auto x = a.all_pieces(), y = b.all_pieces();
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t p = 0; p < x.size(); ++p) {
    ASSERT_EQ(x[p]->id, y[p]->id);
    ASSERT_TRUE(std::ranges::equal(x[p]->tets, y[p]->tets));
    EXPECT_TRUE(std::ranges::equal(x[p]->neighbours, y[p]->neighbours));
    EXPECT_TRUE(std::ranges::equal(x[p]->points, y[p]->points, same_bits));
    for (std::uint32_t t = 0; t < x[p]->tets.size(); ++t)
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t number = a.tet_of({x[p]->id, t});
        EXPECT_EQ(a.background().neighbour(number, f), b.background().neighbour(number, f));
      }
    for (std::uint32_t t = 0; t < x[p]->tets.size(); t += 17) {
      meshing::Point centre;
      for (const std::uint32_t v : x[p]->tets[t]) centre += 0.25 * x[p]->points[v];
      const std::uint32_t number = a.tet_of({x[p]->id, t});
      EXPECT_EQ(a.background().at(centre, number).log_metric, b.background().at(centre, number).log_metric);
    }
  }
}

void expect_same_mesh(const Subdomain& a, const Subdomain& b) {
  const meshing::TetMeshArrays x = to_arrays(*a.mesh), y = to_arrays(*b.mesh);
  EXPECT_EQ(x.tets, y.tets);
  EXPECT_EQ(x.patches, y.patches);
  EXPECT_EQ(x.tet_refs, y.tet_refs);
  EXPECT_EQ(x.tet_marks, y.tet_marks);
  EXPECT_TRUE(std::ranges::equal(x.points, y.points, same_bits));
  EXPECT_EQ(x.log_metrics, y.log_metrics);
  EXPECT_EQ(x.labels, y.labels);
  EXPECT_EQ(x.vertex_tets, y.vertex_tets);
  EXPECT_EQ(x.background_hints, y.background_hints);
  EXPECT_EQ(x.surface_hints, y.surface_hints);
  EXPECT_EQ(x.kinds, y.kinds);
  EXPECT_EQ(x.flags, y.flags);
  EXPECT_EQ(x.vertex_marks, y.vertex_marks);
  for (std::uint32_t i = 0; i < a.mesh->tet_slots(); ++i)
    for (int f = 0; f < 4 && a.mesh->alive(meshing::TetId(i)); ++f)
      EXPECT_EQ(a.mesh->neighbour(meshing::TetId(i), f), b.mesh->neighbour(meshing::TetId(i), f));
}

void expect_same(const Subdomain& a, const Subdomain& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.mesh->tet_capacity(), b.mesh->tet_capacity());
  EXPECT_EQ(a.next_local, b.next_local);
  EXPECT_EQ(a.departures, b.departures);
  EXPECT_TRUE(std::ranges::equal(a.interface.lines(), b.interface.lines()));
  ASSERT_EQ(a.interface.size(), b.interface.size());
  for (std::uint32_t i = 0; i < a.interface.size(); ++i)
    EXPECT_EQ(a.interface.local(i), b.interface.local(i));
  expect_same_mesh(a, b);
  expect_same_background(a.background, b.background);
  EXPECT_TRUE(std::ranges::equal(a.surface.all(), b.surface.all(), [](const auto& x, const auto& y) {
    return std::ranges::equal(x->bytes(), y->bytes());
  }));
}

/// Within a rank parcels and subdomains have the pieces by reference, however often they are packed.
TEST(SubdomainSerialize, TheSurfaceIsNotCopied) {
  const meshing::Surface surface(support::ball(4, 1), {});
  const auto all = surface.pieces().all();
  ASSERT_GT(all.size(), 4u);
  partition::Parcel parcel;
  parcel.surface.assign(all.begin(), all.end());
  for (int journey = 0; journey < 3; ++journey) {
    parcel = engine::unpacked<partition::Parcel>(engine::packed(std::move(parcel)));
    ASSERT_EQ(parcel.surface.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(parcel.surface[i]->id, all[i]->id);
      EXPECT_EQ(parcel.surface[i]->bytes().data(), all[i]->bytes().data());
    }
  }
}

TEST(SubdomainSerialize, EveryStepGivesTheSameAfterAJourney) {
  for (unsigned seed = 0; seed < repetitions(6, 12); ++seed) {
    const Scene scene = random_scene(seed, 1.5);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name);
    const Cut cut = scene.cut();
    Rounds stays(cut, scene.hausd(), {2, false}), travels(cut, scene.hausd(), {2, false});
    const auto travel = [&] {
      for (Subdomain& s : travels.subdomains()) s = travelled(s);
      for (std::size_t i = 0; i < scene.subdomains; ++i)
        expect_same(stays.subdomains()[i], travels.subdomains()[i]);
      return !HasFailure();
    };
    const auto both = [&](auto step) { step(stays), step(travels); };
    ASSERT_TRUE(travel());
    both([](Rounds& r) { r.adapt_interiors(); });
    ASSERT_TRUE(travel());
    for (unsigned round = 0; round < 3; ++round) {
      std::mt19937 random(round);
      const auto priorities = random_priorities(scene.subdomains, random);
      both([&](Rounds& r) { r.shift(priorities); });
      ASSERT_TRUE(travel());
      both([](Rounds& r) { r.adapt(meshing::Extent::fresh); });
      ASSERT_TRUE(travel());
      both([](Rounds& r) { EXPECT_EQ(r.update(), 0); });
      ASSERT_TRUE(travel());
    }
  }
}

TEST(SubdomainSerialize, APieceOfTheBackgroundArrivesWhole) {
  Scene scene = random_scene(0, 1);
  scene.part.assign(scene.mesh.tets.size(), partition::SubdomainId(0));
  scene.subdomains = 1;
  const Cut cut = scene.cut();
  const Subdomain s(cut.starts[0], 10000);
  BackgroundStore joined;
  std::vector<std::shared_ptr<const partition::BackgroundPiece>> arrived;
  engine::Packer packer;
  partition::serialize_pieces(packer, s.background.all_pieces());
  engine::Unpacker unpacker(packer.take());
  partition::serialize_pieces(unpacker, arrived);
  unpacker.finish();
  for (std::size_t i = 0; i < arrived.size(); ++i)
    EXPECT_EQ(arrived[i]->bytes().data(), s.background.all_pieces()[i]->bytes().data()) << "no copy";
  joined.add(arrived);
  expect_same_background(s.background, joined);
}

}  // namespace
}  // namespace weft::graph::adaptation::subdomain_serialize_test

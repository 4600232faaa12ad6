// Subdomains whose arrays are too small at first.
#include <gtest/gtest.h>

#include "meshing/kernel/tet_mesh_arrays.h"
#include "partition/subdomain/adapt_subdomain.h"
#include "tests/partition/scenes.h"
#include "tests/partition/shift/rounds.h"

namespace weft::partition::room_test {
namespace {

using namespace weft::support;

/// A cube in two halves whose metric wants several times its tets.
Scene growing_cube() {
  Scene scene;
  scene.mesh = unit_cube(4);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.12, 3);
  scene.subdomains = 2;
  for (const auto& tet : scene.mesh.tets) {
    double x = 0;
    for (const std::uint32_t v : tet) x += scene.mesh.points[v].x / 4;
    scene.part.emplace_back(x < 0.5 ? 0u : 1u);
  }
  return scene;
}

/// Room for what the subdomains have, and no more.
void take_the_room(const Cut& cut, Rounds& rounds) {
  for (std::size_t i = 0; i < cut.starts.size(); ++i)
    rounds.subdomains()[i] = Subdomain(cut.starts[i], cut.starts[i].tets.size());
}

std::uint64_t tets_of(const Rounds& rounds) {
  std::uint64_t tets = 0;
  for (const MeshPiece& piece : rounds.pieces()) tets += piece.mesh.tets.size();
  return tets;
}

TEST(Room, MovingASubdomainToLargerArraysChangesNothing) {
  const Cut cut = growing_cube().cut();
  Subdomain s(cut.starts[0], cut.starts[0].tets.size());
  const meshing::TetMeshArrays before = to_arrays(*s.mesh);
  const auto slots = s.mesh->tet_slots();
  make_room(s, 100'000);
  EXPECT_GE(s.mesh->tet_capacity(), slots + 100'000);
  EXPECT_EQ(s.mesh->tet_slots(), slots);
  const meshing::TetMeshArrays after = to_arrays(*s.mesh);
  EXPECT_EQ(after.tets, before.tets);
  EXPECT_EQ(after.patches, before.patches);
  EXPECT_EQ(after.labels, before.labels);
  EXPECT_EQ(after.flags, before.flags);
  EXPECT_EQ(after.log_metrics, before.log_metrics);
  const meshing::TetMesh* const mesh = s.mesh.get();
  make_room(s, 100);
  EXPECT_EQ(s.mesh.get(), mesh) << "there was room";
}

TEST(Room, ASubdomainThatBecomesFullIsAdaptedToTheEndAllTheSame) {
  const Scene scene = growing_cube();
  const Cut cut = scene.cut();
  Rounds ample(cut, scene.hausd(), {2, false});
  ample.adapt(meshing::Extent::everything);
  Subdomain s(cut.starts[0], cut.starts[0].tets.size());
  const auto wanted = count_tets(ample.subdomains()[0]);
  ASSERT_GT(wanted, 5 * count_tets(s)) << "the scene is too coarse for the test";
  const meshing::AdaptReport report =
      adapt_subdomain(s, cut.geometry.surface, ample.limits(), meshing::Extent::everything, ample.options());
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_FALSE(s.mesh->is_full());
  EXPECT_NEAR(static_cast<double>(count_tets(s)), static_cast<double>(wanted),
              0.1 * static_cast<double>(wanted));
}

TEST(Room, InterfacesAreRefinedWhereThereWasTooLittle) {
  const Scene scene = growing_cube();
  const Cut cut = scene.cut();
  Rounds ample(cut, scene.hausd(), {2, false}), tight(cut, scene.hausd(), {2, false});
  take_the_room(cut, tight);
  for (Rounds* rounds : {&ample, &tight}) rounds->refine_interfaces();
  EXPECT_GT(tets_of(tight), 2 * cut.starts[0].tets.size() + 2 * cut.starts[1].tets.size());
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(to_arrays(*tight.subdomains()[i].mesh).tets, to_arrays(*ample.subdomains()[i].mesh).tets);
}

TEST(Room, WhatAShiftBringsFindsRoom) {
  const Scene scene = growing_cube();
  const Cut cut = scene.cut();
  Rounds ample(cut, scene.hausd(), {2, false}), tight(cut, scene.hausd(), {2, false});
  take_the_room(cut, tight);
  const std::vector<Priority> priorities = {{2, SubdomainId(0)}, {1, SubdomainId(1)}};
  for (Rounds* rounds : {&ample, &tight}) {
    EXPECT_GT(rounds->shift(priorities), 0u);
    EXPECT_EQ(rounds->update(), 0);
  }
  EXPECT_EQ(tets_of(tight), tets_of(ample));
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(to_arrays(*tight.subdomains()[i].mesh).tets, to_arrays(*ample.subdomains()[i].mesh).tets);
}

}  // namespace
}  // namespace weft::partition::room_test

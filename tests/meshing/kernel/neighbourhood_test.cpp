// Tests of balls and shells on hand-made configurations.
#include "meshing/kernel/neighbourhood.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "meshing/kernel/quality.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::neighbourhood_test {
namespace {

using support::half_ring_of;
using support::KernelRig;
using support::octahedron;
using support::ring_of;

Verdict shell_of(KernelRig& rig, VertexId a, VertexId b, Shell& shell) {
  const TetId t = rig.tet_with(a, b);
  EXPECT_EQ(rig.worker.claims.claim_tet(t), Verdict::accepted);
  return gather_shell(rig.mesh, rig.worker.claims, t, a, b, shell);
}

/// Entry s is (a, b, ring[s], ring[s + 1]), positive, and the local indices say so.
void expect_turning_round(const TetMesh& mesh, const Shell& shell) {
  std::set<std::uint32_t> tets;
  for (int s = 0; s < shell.size; ++s) {
    const auto& e = shell.tets[s];
    tets.insert(e.tet.value);
    EXPECT_EQ(mesh.vertex(e.tet, e.a), shell.a);
    EXPECT_EQ(mesh.vertex(e.tet, e.b), shell.b);
    EXPECT_EQ(mesh.vertex(e.tet, e.r), shell.ring[s]);
    EXPECT_EQ(mesh.vertex(e.tet, e.s), shell.ring[s + 1]);
    EXPECT_GT(
        judge_quality(MetricMean::arithmetic, mesh, {shell.a, shell.b, shell.ring[s], shell.ring[s + 1]}), 0);
  }
  EXPECT_EQ(tets.size(), static_cast<std::size_t>(shell.size)) << "a tet came twice";
}

TEST(Shell, OfAnInteriorEdgeIsClosed) {
  for (std::uint32_t n = 3; n <= 12; ++n) {
    KernelRig rig(ring_of(n, 1));
    for (const auto& [a, b] : {std::pair(VertexId(0), VertexId(1)), std::pair(VertexId(1), VertexId(0))}) {
      Shell shell;
      ASSERT_EQ(shell_of(rig, a, b, shell), Verdict::accepted);
      EXPECT_TRUE(shell.closed);
      EXPECT_EQ(shell.size, static_cast<int>(n));
      EXPECT_EQ(shell.ring[0], shell.ring[shell.size]);
      expect_turning_round(rig.mesh, shell);
      for (std::uint32_t v = 0; v < n + 2; ++v) EXPECT_TRUE(rig.worker.claims.holds(VertexId(v)));
      rig.worker.claims.release();
    }
  }
}

TEST(Shell, OfABoundaryEdgeIsOpenFromAnyOfItsTets) {
  for (std::uint32_t n = 2; n <= 6; ++n) {
    KernelRig rig(half_ring_of(n, 1));
    for (const TetId start : rig.live_tets()) {
      Shell shell;
      ASSERT_EQ(rig.worker.claims.claim_tet(start), Verdict::accepted);
      ASSERT_EQ(gather_shell(rig.mesh, rig.worker.claims, start, VertexId(0), VertexId(1), shell),
                Verdict::accepted);
      EXPECT_FALSE(shell.closed);
      ASSERT_EQ(shell.size, static_cast<int>(n));
      EXPECT_EQ(shell.ring[0], VertexId(2));
      EXPECT_EQ(shell.ring[shell.size], VertexId(n + 2));
      EXPECT_FALSE(rig.mesh.neighbour(shell.tets[0].tet, shell.tets[0].s).valid());
      EXPECT_FALSE(rig.mesh.neighbour(shell.tets[n - 1].tet, shell.tets[n - 1].r).valid());
      expect_turning_round(rig.mesh, shell);
      for (std::uint32_t v = 0; v < n + 3; ++v) EXPECT_TRUE(rig.worker.claims.holds(VertexId(v)));
      rig.worker.claims.release();
    }
  }
}

TEST(Shell, OfManyTetsIsTooLarge) {
  for (const std::uint32_t n : {Shell::kMaxSize, Shell::kMaxSize + 1}) {
    KernelRig rig(ring_of(n, 1));
    Shell shell;
    EXPECT_EQ(shell_of(rig, VertexId(0), VertexId(1), shell),
              n > Shell::kMaxSize ? Verdict::too_large : Verdict::accepted);
  }
  KernelRig open(half_ring_of(Shell::kMaxSize + 3, 1));
  Shell shell;
  EXPECT_EQ(shell_of(open, VertexId(0), VertexId(1), shell), Verdict::too_large);
}

TEST(Shell, RefusesAFrozenVertexAndOneThatAnotherHolds) {
  KernelRig rig(ring_of(6, 1));
  Claims other(rig.mesh, 2, false, support::kClaimable);
  const TetId t = rig.tet_with(VertexId(0), VertexId(2));
  const auto gather = [&] {
    Shell shell;
    EXPECT_EQ(rig.worker.claims.claim_tet(t), Verdict::accepted);
    const Verdict r = gather_shell(rig.mesh, rig.worker.claims, t, VertexId(0), VertexId(1), shell);
    rig.worker.claims.release();
    return r;
  };
  ASSERT_EQ(other.claim(VertexId(5)), Verdict::accepted);
  EXPECT_EQ(gather(), Verdict::conflict);
  other.release();
  EXPECT_EQ(gather(), Verdict::accepted);
  rig.mesh.freeze(VertexId(5));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  EXPECT_EQ(gather(), Verdict::frozen);
}

TEST(Ball, OfAnInteriorVertexIsAllAroundIt) {
  KernelRig rig(octahedron());
  Ball ball;
  ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), ball), Verdict::accepted);
  EXPECT_EQ(ball.centre, VertexId(0));
  EXPECT_EQ(ball.tets.size(), 8u);
  for (const auto& [t, local] : ball.tets) EXPECT_EQ(rig.mesh.vertex(t, local), VertexId(0));
  for (std::uint32_t v = 0; v < 7; ++v) EXPECT_TRUE(rig.worker.claims.holds(VertexId(v)));
}

TEST(Ball, IsEveryTetOfTheVertexAndNoOther) {
  MeshData input = support::unit_cube_of_fives(3);
  support::shuffle(input);
  KernelRig rig(input);
  for (const VertexId v : rig.live_vertices()) {
    Ball ball;
    ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, v, ball), Verdict::accepted);
    std::set<std::uint32_t> gathered, expected;
    for (const auto& entry : ball.tets) gathered.insert(entry.tet.value);
    for (const TetId t : rig.live_tets())
      if (rig.mesh.local_index(t, v) >= 0) expected.insert(t.value);
    EXPECT_EQ(gathered, expected);
    EXPECT_EQ(gathered.size(), ball.tets.size());
    for (const VertexId u : rig.neighbours_of(v)) EXPECT_TRUE(rig.worker.claims.holds(u));
    rig.worker.claims.release();
  }
  support::expect_sound(rig.mesh);
}

TEST(Ball, HasItsLinkInTheOrderOfItsTets) {
  MeshData input = support::unit_cube_of_fives(3);
  support::shuffle(input);
  KernelRig rig(input);
  for (const VertexId v : rig.live_vertices()) {
    Ball ball;
    ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, v, ball), Verdict::accepted);
    std::set<std::uint32_t> seen;
    std::vector<std::pair<std::uint32_t, std::size_t>> expected, link;
    for (std::size_t i = 0; i < ball.tets.size(); ++i)
      for (const VertexId u : rig.mesh.vertices(ball.tets[i].tet))
        if (u != v && seen.insert(u.value).second) expected.emplace_back(u.value, i);
    for (const auto& [u, first] : ball.link) link.emplace_back(u.value, first);
    EXPECT_EQ(link, expected);
    EXPECT_EQ(link.size(), rig.neighbours_of(v).size());
    rig.worker.claims.release();
  }
}

TEST(Ball, IsTheSameForAWorkerThatWorksAlone) {
  KernelRig rig(support::unit_cube_of_fives(3));
  Claims alone(rig.mesh, 2, true, rig.kernel.policy.frozen);
  for (const VertexId v : rig.live_vertices()) {
    Ball claimed, unclaimed;
    ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, v, claimed), Verdict::accepted);
    rig.worker.claims.release();
    ASSERT_EQ(gather_ball(rig.mesh, alone, v, unclaimed), Verdict::accepted);
    ASSERT_EQ(claimed.tets.size(), unclaimed.tets.size());
    for (std::size_t i = 0; i < claimed.tets.size(); ++i)
      EXPECT_EQ(claimed.tets[i].tet, unclaimed.tets[i].tet);
  }
  rig.mesh.freeze(VertexId(5));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  EXPECT_EQ(alone.claim(VertexId(5)), Verdict::frozen);
}

TEST(Ball, RefusesAFrozenVertexAndOneThatAnotherHolds) {
  KernelRig rig(octahedron());
  Claims other(rig.mesh, 2, false, support::kClaimable);
  Ball ball;
  ASSERT_EQ(other.claim(VertexId(6)), Verdict::accepted);
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), ball), Verdict::conflict);
  rig.worker.claims.release();
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(6), ball), Verdict::conflict);
  rig.worker.claims.release();
  other.release();
  rig.mesh.freeze(VertexId(6));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), ball), Verdict::frozen);
  rig.worker.claims.release();
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(6), ball), Verdict::frozen);
  rig.worker.claims.release();
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(5), ball), Verdict::accepted)
      << "not a neighbour of the frozen one";
}

TEST(Ball, OfADeadVertexIsNotNeeded) {
  KernelRig rig(octahedron());
  rig.mesh.kill(VertexId(0));
  Ball ball;
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), ball), Verdict::not_needed);
}

TEST(Ball, OfManyTetsIsTooLarge) {
  KernelRig rig(support::ball(3, 1));  // 1280 tets around the centre
  Ball ball;
  EXPECT_EQ(gather_ball(rig.mesh, rig.worker.claims, VertexId(0), ball), Verdict::too_large);
}

TEST(SmallSet, HoldsWhatWasInsertedSinceItWasCleared) {
  SmallSet set;
  for (int round = 0; round < 3; ++round) {
    set.clear();
    for (std::uint32_t i = 0; i < 5000; ++i)
      EXPECT_TRUE(set.insert(7 * i + static_cast<std::uint32_t>(round)));
    for (std::uint32_t i = 0; i < 5000; ++i) {
      EXPECT_FALSE(set.insert(7 * i + static_cast<std::uint32_t>(round)));
      EXPECT_TRUE(set.contains(7 * i + static_cast<std::uint32_t>(round)));
      EXPECT_FALSE(set.contains(7 * i + static_cast<std::uint32_t>(round) + 3));
    }
  }
}

}  // namespace
}  // namespace weft::meshing::neighbourhood_test

// Tests of the kernel's mesh: slots, marks, claims, feature edges, and renumbering.
#include "meshing/kernel/tet_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>

#include "meshing/adapt/check_whole.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/kernel/renumber.h"
#include "meshing/kernel/speculation.h"
#include "meshing/kernel/tet_mesh_arrays.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::tet_mesh_test {
namespace {

using support::expect_same_domain;
using support::expect_sound;
using support::KernelRig;

TEST(TetMesh, FreshSlotsAreDead) {
  TetMesh mesh(10, 10);
  EXPECT_EQ(mesh.take_vertex_slots(4), 0u);
  EXPECT_EQ(mesh.take_vertex_slots(2), 4u);
  EXPECT_EQ(mesh.take_tet_slots(3), 0u);
  EXPECT_EQ(mesh.vertex_slots(), 6u);
  EXPECT_EQ(mesh.tet_slots(), 3u);
  for (std::uint32_t i = 0; i < 6; ++i) EXPECT_FALSE(mesh.alive(VertexId(i)));
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(mesh.alive(TetId(i)));
    for (int f = 0; f < 4; ++f) EXPECT_FALSE(mesh.patch(TetId(i), f).valid());
  }
}

TEST(TetMesh, NoMoreSlotsThanThereIsRoomFor) {
  TetMesh mesh(5, 7);
  mesh.take_vertex_slots(4);
  mesh.take_tet_slots(7);
  EXPECT_THROW(mesh.take_vertex_slots(2), std::length_error);
  EXPECT_THROW(mesh.take_tet_slots(1), std::length_error);
  EXPECT_EQ(mesh.vertex_slots(), 4u) << "a refused request takes nothing";
  EXPECT_EQ(mesh.take_vertex_slots(1), 4u);
}

TEST(TetMesh, SaysWhenItIsFull) {
  TetMesh mesh(10, 10);
  EXPECT_EQ(mesh.try_take_tet_slots(8), 0u);
  EXPECT_FALSE(mesh.is_full());
  EXPECT_EQ(mesh.try_take_tet_slots(8), std::nullopt);
  EXPECT_EQ(mesh.tet_slots(), 8u);
  EXPECT_TRUE(mesh.is_full());
}

TEST(TetMesh, GrowsWithAllThatItHas) {
  const auto mesh = import_mesh(support::unit_cube(2), 40, 100, 1000).mesh;
  const TetMeshArrays before = to_arrays(*mesh);
  EXPECT_EQ(mesh->try_take_tet_slots(1u << 29), std::nullopt);
  const std::size_t room = mesh->tet_capacity();
  ASSERT_TRUE(mesh->grow());
  EXPECT_FALSE(mesh->is_full());
  EXPECT_GE(mesh->tet_capacity(), 4 * room);
  const TetMeshArrays after = to_arrays(*mesh);
  EXPECT_EQ(after.tets, before.tets);
  EXPECT_EQ(after.patches, before.patches);
  EXPECT_EQ(after.log_metrics, before.log_metrics);
  EXPECT_EQ(after.vertex_tets, before.vertex_tets);
  EXPECT_TRUE(links_hold(*mesh));
  EXPECT_TRUE(mesh->try_take_tet_slots(static_cast<std::uint32_t>(2 * room)));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(TetMesh, MakesDoWithLessAddressSpace) {
  const auto with_little_space = [](Room least) {
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = std::size_t{4} << 30;
    setrlimit(RLIMIT_AS, &limit);
    try {
      const auto mesh = reserve_tet_mesh({1u << 29, 1u << 29}, least);
      std::exit(mesh->tet_capacity() >= 1u << 20 && mesh->tet_capacity() < 1u << 29 ? 0 : 1);
    } catch (const NoAddressSpace& e) {
      std::fputs(e.what(), stderr);
      std::exit(2);
    }
  };
  EXPECT_EXIT(with_little_space({1000, 1000}), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(with_little_space({1u << 28, 1u << 28}), testing::ExitedWithCode(2), "ulimit -v");
}
#endif

TEST(TetMesh, ThreadsNeverGetTheSameSlot) {
  constexpr int kThreads = 4, kTakes = 1000;
  TetMesh mesh(10, 3 * kThreads * kTakes);
  std::vector<std::vector<std::uint32_t>> firsts(kThreads);
  {
    std::vector<std::jthread> threads;
    for (auto& mine : firsts)
      threads.emplace_back([&mesh, &mine] {
        for (int i = 0; i < kTakes; ++i) mine.push_back(mesh.take_tet_slots(3));
      });
  }
  std::set<std::uint32_t> all;
  for (const auto& mine : firsts) all.insert(mine.begin(), mine.end());
  EXPECT_EQ(all.size(), static_cast<std::size_t>(kThreads * kTakes));
  for (const std::uint32_t first : all) EXPECT_EQ(first % 3, 0u);
}

TEST(TetMesh, AKilledTetAndVertexAreDeadAndUnmarked) {
  KernelRig rig(support::two_tets());
  const TetId t = rig.live_tets().front();
  rig.mesh.mark(t, kAllTetMarks);
  rig.mesh.kill(t);
  EXPECT_FALSE(rig.mesh.alive(t));
  EXPECT_EQ(rig.mesh.marks(t), 0);
  rig.mesh.mark(VertexId(3), kCheckPlace);
  rig.mesh.kill(VertexId(3));
  EXPECT_FALSE(rig.mesh.alive(VertexId(3)));
  EXPECT_EQ(rig.mesh.marks(VertexId(3)), 0);
}

TEST(TetMesh, MarksAreTakenOnceAndOneByOne) {
  KernelRig rig(support::two_tets());
  TetMesh& mesh = rig.mesh;
  mesh.mark(TetId(0), kCheckLong | kCheckPoor);
  EXPECT_EQ(mesh.take_marks(TetId(0), kCheckSwap), 0);
  EXPECT_EQ(mesh.take_marks(TetId(0), kCheckLong), kCheckLong);
  EXPECT_EQ(mesh.take_marks(TetId(0), kCheckLong), 0);
  EXPECT_EQ(mesh.marks(TetId(0)), kCheckPoor);
  EXPECT_EQ(mesh.marks(TetId(1)), 0);
}

TEST(TetMesh, ARefusedEdgeIsRememberedUntilTheTetIsToBeLookedAt) {
  KernelRig rig(support::two_tets());
  TetMesh& mesh = rig.mesh;
  EXPECT_EQ(mesh.refused_edge(TetId(0)), -1);
  mesh.mark(TetId(0), kCheckLong | kFresh);
  for (const int edge : {5, 0, 3}) {
    mesh.set_refused_edge(TetId(0), edge);
    EXPECT_EQ(mesh.refused_edge(TetId(0)), edge);
    EXPECT_EQ(mesh.take_marks(TetId(0), kCheckLong), edge == 5 ? kCheckLong : 0);
  }
  mesh.mark(TetId(0), kCheckSwap | kCheckPoor);
  EXPECT_EQ(mesh.refused_edge(TetId(0)), 3);
  mesh.mark(TetId(0), kAllTetMarks);
  EXPECT_EQ(mesh.refused_edge(TetId(0)), -1);
  EXPECT_EQ(mesh.marks(TetId(0)), kAllTetMarks | kFresh);
  EXPECT_EQ(mesh.refused_edge(TetId(1)), -1);
}

TEST(TetMesh, FeatureEdgesAreFoundFromBothEnds) {
  TetMesh mesh(10, 10);
  mesh.set_kind(VertexId(2), VertexKind::corner);
  mesh.set_kind(VertexId(7), VertexKind::ridge);
  mesh.set_curve(VertexId(7), VertexId(2), CurveId(3));
  EXPECT_EQ(mesh.curve(VertexId(2), VertexId(7)), CurveId(3));
  EXPECT_EQ(mesh.curve(VertexId(7), VertexId(2)), CurveId(3));
  EXPECT_FALSE(mesh.curve(VertexId(2), VertexId(6)).valid());
  mesh.set_curve(VertexId(2), VertexId(7), CurveId(4));
  ASSERT_EQ(mesh.feature_edges().size(), 1u);
  EXPECT_EQ(mesh.feature_edges()[0].curve, CurveId(4));
  mesh.set_curve(VertexId(2), VertexId(7), CurveId());
  EXPECT_FALSE(mesh.curve(VertexId(7), VertexId(2)).valid());
  EXPECT_TRUE(mesh.feature_edges().empty());
  mesh.set_curve(VertexId(2), VertexId(7), CurveId());  // erasing nothing is fine
}

TEST(TetMesh, FeatureEdgesComeSorted) {
  TetMesh mesh(10, 10);
  for (const auto& [a, b] : {std::pair{5, 1}, {0, 9}, {3, 1}, {0, 2}})
    mesh.set_curve(VertexId(static_cast<std::uint32_t>(a)), VertexId(static_cast<std::uint32_t>(b)),
                   CurveId(0));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (const auto& e : mesh.feature_edges()) ends.emplace_back(e.a.value, e.b.value);
  EXPECT_THAT(
      ends, testing::ElementsAre(std::pair(0u, 2u), std::pair(0u, 9u), std::pair(1u, 3u), std::pair(1u, 5u)));
}

TEST(Claims, AClaimedVertexIsAConflictForOthersUntilItIsReleased) {
  TetMesh mesh(10, 10);
  Claims mine(mesh, 1, false, support::kClaimable), other(mesh, 2, false, support::kClaimable);
  EXPECT_EQ(mine.claim(VertexId(4)), Verdict::accepted);
  EXPECT_EQ(mine.claim(VertexId(4)), Verdict::accepted) << "held already";
  EXPECT_TRUE(mine.holds(VertexId(4)));
  EXPECT_FALSE(other.holds(VertexId(4)));
  EXPECT_EQ(other.claim(VertexId(4)), Verdict::conflict);
  EXPECT_EQ(other.claim(VertexId(5)), Verdict::accepted);
  mine.release();
  EXPECT_EQ(other.claim(VertexId(4)), Verdict::accepted);
  other.release();
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(mesh.claim_word(VertexId(i)), TetMesh::kFree);
}

TEST(Claims, AFrozenVertexIsNeverClaimedAndStaysFrozen) {
  TetMesh mesh(10, 10);
  mesh.freeze(VertexId(3));
  for (const bool sole : {true, false}) {
    const FrozenPolicy policy = FrozenPolicy::untouchable;
    Claims claims(mesh, 1, sole, policy);
    EXPECT_EQ(claims.claim(VertexId(3)), Verdict::frozen);
    EXPECT_FALSE(claims.holds(VertexId(3)));
    claims.release();
    EXPECT_TRUE(mesh.frozen(VertexId(3)));
  }
}

TEST(Claims, ATetIsClaimedByItsFourVertices) {
  KernelRig rig(support::two_tets());
  Claims other(rig.mesh, 2, false, support::kClaimable), mine(rig.mesh, 3, false, support::kClaimable);
  EXPECT_EQ(mine.claim_tet(TetId(0)), Verdict::accepted);
  for (const VertexId v : rig.mesh.vertices(TetId(0))) EXPECT_TRUE(mine.holds(v));
  EXPECT_EQ(other.claim_tet(TetId(1)), Verdict::conflict);
  other.release();
  mine.release();
  rig.mesh.kill(TetId(0));
  EXPECT_EQ(mine.claim_tet(TetId(0)), Verdict::not_needed) << "a dead tet";
}

TEST(Claims, OneOfManyThreadsGetsAVertex) {
  constexpr int kThreads = 4, kVertices = 2000;
  TetMesh mesh(kVertices, 10);
  std::vector<int> won(kThreads, 0);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i)
      threads.emplace_back([&mesh, &won, i] {
        Claims claims(mesh, static_cast<std::uint32_t>(i + 1), false, support::kClaimable);
        for (std::uint32_t v = 0; v < kVertices; ++v)
          won[static_cast<std::size_t>(i)] += claims.claim(VertexId(v)) == Verdict::accepted;
      });
  }
  EXPECT_EQ(std::accumulate(won.begin(), won.end(), 0), kVertices);
}

TEST(Renumber, KeepsTheMesh) {
  MeshData input = support::layered_box(3, 2, 2);
  support::jitter_interior(input, 0.05);
  support::shuffle(input);
  KernelRig rig(input, 0.3);
  const std::size_t num_features = rig.mesh.feature_edges().size();
  rig.mesh.freeze(VertexId(17));
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  rig.mesh.mark(VertexId(17), kCheckShort);
  const Point frozen = rig.mesh.point(VertexId(17));
  renumber_along_curve(rig.mesh);
  expect_sound(rig.mesh);
  EXPECT_EQ(rig.mesh.feature_edges().size(), num_features);
  const VertexId now = rig.vertex_at(frozen);
  EXPECT_EQ(rig.mesh.point(now), frozen);
  EXPECT_TRUE(rig.mesh.frozen(now));
  EXPECT_EQ(rig.mesh.marks(now), kCheckShort);
  const MeshData data = rig.export_data();
  EXPECT_EQ(data.points.size(), input.points.size());
  EXPECT_EQ(data.tets.size(), input.tets.size());
  expect_same_domain(data, input);
  support::expect_same_lengths(data, rig.input);
}

TEST(Renumber, ClosesHolesAndSlotsCanBeTakenAgain) {
  KernelRig rig(support::unit_cube(2), 0.5);
  // Holes between live slots: fresh slots that nobody writes.
  const std::uint32_t vertices = rig.mesh.vertex_slots(), tets = rig.mesh.tet_slots();
  rig.mesh.take_vertex_slots(100);
  rig.mesh.take_tet_slots(100);
  renumber_along_curve(rig.mesh);
  EXPECT_EQ(rig.mesh.vertex_slots(), vertices);
  EXPECT_EQ(rig.mesh.tet_slots(), tets);
  EXPECT_EQ(rig.live_tets().size(), tets);
  EXPECT_FALSE(rig.mesh.alive(VertexId(rig.mesh.take_vertex_slots(1))));
  EXPECT_FALSE(rig.mesh.alive(TetId(rig.mesh.take_tet_slots(1))));
}

TEST(Renumber, LeavesAMeshInOrder) {
  MeshData input = support::unit_cube(20);
  support::shuffle(input);
  KernelRig rig(input, 0.05);
  EXPECT_FALSE(is_in_order(rig.mesh));
  renumber_along_curve(rig.mesh);
  EXPECT_TRUE(is_in_order(rig.mesh));
}

/// As a subdomain's that is a stretch of a file of pieces: vertices of the interface are numbered in others'.
TEST(Renumber, LeavesAMeshThatHasItsBoundaryFirst) {
  KernelRig rig(support::unit_cube(10), 0.05);
  renumber_along_curve(rig.mesh);
  MeshData input = rig.export_data();
  std::vector<std::uint32_t> old_to_new(input.points.size());
  std::uint32_t next = 0;
  for (const bool first : {true, false})
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      const Point& p = input.points[v];
      const bool inside = std::min({p.x, p.y, p.z}) > 0 && std::max({p.x, p.y, p.z}) < 1;
      if (inside != first) old_to_new[v] = next++;
    }
  support::renumber_points(input, old_to_new);
  EXPECT_TRUE(is_in_order(KernelRig(input, 0.05).mesh));
}

TEST(Renumber, PutsNearVerticesNearEachOther) {
  MeshData input = support::unit_cube(8);
  support::shuffle(input);
  KernelRig rig(input, 0.5);
  const auto mean_jump = [&] {
    double sum = 0;
    for (std::uint32_t i = 1; i < rig.mesh.vertex_slots(); ++i)
      sum += norm(rig.mesh.point(VertexId(i)) - rig.mesh.point(VertexId(i - 1)));
    return sum / (rig.mesh.vertex_slots() - 1);
  };
  const double before = mean_jump();
  renumber_along_curve(rig.mesh);
  EXPECT_LT(mean_jump(), 0.5 * before);
}

TEST(Renumber, NearIsNearInTheMetric) {
  MeshData input = support::unit_cube(8);
  support::shuffle(input);
  // Lengths along (1, 1, 0) count sixteen times as much as those across it: the order is along it.
  const double r = 1 / std::sqrt(2.0);
  const Metric metric = from_eigen({{64, 64, 64 * 256}, {Vec{r, -r, 0}, Vec{0, 0, 1}, Vec{r, r, 0}}});
  KernelRig rig(input, LogMetricField(input.points.size(), log_of(metric)));
  renumber_along_curve(rig.mesh);
  const auto along = [&](std::uint32_t i) {
    return rig.mesh.point(VertexId(i)).x + rig.mesh.point(VertexId(i)).y;
  };
  const std::uint32_t size = rig.mesh.vertex_slots(), half = size / 2;
  double last_of_first = 0, first_of_last = 2;
  for (std::uint32_t i = 0; i < size; ++i)
    if (i < half)
      last_of_first = std::max(last_of_first, along(i));
    else
      first_of_last = std::min(first_of_last, along(i));
  EXPECT_LE(last_of_first, first_of_last + 1e-9);
}

}  // namespace
}  // namespace weft::meshing::tet_mesh_test

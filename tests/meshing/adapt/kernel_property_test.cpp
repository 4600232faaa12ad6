// Random operator sequences on random meshes and metrics: whatever is accepted, the mesh stays right.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <thread>

#include "meshing/adapt/passes.h"
#include "meshing/operators/collapse_edge.h"
#include "meshing/operators/relocate_vertex.h"
#include "meshing/operators/smooth_vertex.h"
#include "meshing/operators/split_edge.h"
#include "meshing/operators/swap_edge.h"
#include "meshing/operators/swap_face.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::kernel_property_test {
namespace {

using support::expect_same_domain;
using support::expect_sound;
using support::KernelRig;

/// One random metric a vertex: sizes between `size` e^-spread and `size` e^spread in random directions.
LogMetricField random_field(const MeshData& mesh, double size, double spread, std::mt19937& random) {
  std::uniform_real_distribution<double> exponent(-2 * spread, 2 * spread), part(-1, 1);
  LogMetricField field;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    Vec a{part(random), part(random), part(random)};
    a = (1 / norm(a)) * a;
    Vec b = cross(a, {a.y, a.z + 1, -a.x});
    b = (1 / norm(b)) * b;
    const double base = -2 * std::log(size);
    field.push_back(from_eigen(
        {{base + exponent(random), base + exponent(random), base + exponent(random)}, {a, b, cross(a, b)}}));
  }
  return field;
}

/// Applies random operators to random entities and counts what came of it.
class Shaker {
 public:
  Shaker(Worker& w, unsigned seed) : w_(w), mesh_(w.mesh), random_(seed) {}

  void shake(int operations) {
    for (int i = 0; i < operations; ++i) {
      const auto [op, verdict] = one(random_tet());
      w_.claims.release();
      counts.add(op, verdict);
    }
  }

  OperationCounts counts;

 private:
  std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(random_() % n); }

  TetId random_tet() {
    for (;;)
      if (const TetId t(below(mesh_.tet_slots())); mesh_.alive(t)) return t;
  }

  std::pair<Operator, Verdict> one(TetId t) {
    const std::uint32_t what = below(8);
    if (what < 3) return {Operator::collapse, collapse(mesh_.vertex(t, static_cast<int>(below(4))))};
    if (what == 3) return {Operator::smooth, smooth_vertex(w_, mesh_.vertex(t, static_cast<int>(below(4))))};
    if (what == 4)
      return {Operator::relocate, relocate_vertex(w_, mesh_.vertex(t, static_cast<int>(below(4))))};
    // From the claim on the tet stays as it is.
    const Verdict claimed = w_.claims.claim_tet(t);
    const TetVertices v = mesh_.vertices(t);
    const auto& e = kTetEdges[below(6)];
    const auto after = [&](auto operation) { return claimed == Verdict::accepted ? operation() : claimed; };
    if (what == 5)
      return {Operator::split, after([&] { return split_edge(w_, t, v[e[0]], v[e[1]], {0.05}); })};
    if (what == 6) return {Operator::swap_edge, after([&] { return swap_edge(w_, t, v[e[0]], v[e[1]]); })};
    return {Operator::swap_face, after([&] { return swap_face(w_, t, static_cast<int>(below(4))); })};
  }

  Verdict collapse(VertexId v) {
    if (const Verdict r = gather_ball(mesh_, w_.claims, v, w_.ball); r != Verdict::accepted) return r;
    const auto [t, local] = w_.ball.tets[below(w_.ball.tets.size())];
    const VertexId kept = mesh_.vertex(t, (local + 1 + static_cast<int>(below(3))) % 4);
    return collapse_edge(w_, w_.ball.centre, kept,
                         below(4) > 0 ? CollapseGoal::length : CollapseGoal::quality);
  }

  Worker& w_;
  TetMesh& mesh_;
  std::mt19937 random_;
};

/// Bounds that let nearly everything through.
void loosen(Limits& limits) {
  limits.collapse_longest = 20;
  limits.collapse_quality = 0.01;
  limits.split_quality = 0.001;
  limits.shortest_step = 1e-4;
}

void expect_metrics_of_the_background(const KernelRig& rig) {
  double worst = 0;
  for (const VertexId v : rig.live_vertices()) {
    const LogMetric found = rig.background.at(rig.mesh.point(v), rig.mesh.background_hint(v)).log_metric;
    const SymTensor d = rig.mesh.log_metric(v) - found;
    worst = std::max({worst, std::abs(d.xx), std::abs(d.xy), std::abs(d.yy), std::abs(d.xz), std::abs(d.yz),
                      std::abs(d.zz)});
  }
  EXPECT_LT(worst, 1e-8);
}

/// Shakes in batches and checks everything after each. The input's ridges must be listed as edges with
/// references.
void shake_and_check(const MeshData& mesh, double size, double spread, unsigned seed, int batches,
                     int operations, OperationCounts& counts) {
  std::mt19937 random(seed);
  KernelRig rig(mesh, random_field(mesh, size, spread, random));
  loosen(rig.kernel.limits);
  Shaker shaker(rig.worker, seed);
  for (int batch = 0; batch < batches && !testing::Test::HasFailure(); ++batch) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", batch " + std::to_string(batch));
    rig.judge_by(batch % 2 ? MetricMean::log_euclidean : MetricMean::arithmetic);
    shaker.shake(operations);
    expect_sound(rig.mesh, true, rig.kernel.policy.mean);
    expect_metrics_of_the_background(rig);
    const MeshData data = rig.export_data();
    expect_sound(rig.mesh, true, rig.kernel.policy.mean);
    expect_same_domain(data, mesh);
    if (!mesh.edges.empty()) support::expect_same_lengths(data, mesh);
    // Through the door again: nothing is missing, and the geometry is found as it was.
    const ImportedMesh again = import_mesh(data, 45, data.points.size(), data.tets.size());
    EXPECT_TRUE(again.warnings.empty()) << again.warnings.front();
    EXPECT_EQ(again.surface->patches().size(), rig.imported.surface->patches().size());
    EXPECT_EQ(again.surface->curves().size(), rig.imported.surface->curves().size());
  }
  counts += shaker.counts;
}

void expect_all_operators_acted(const OperationCounts& counts) {
  for (std::size_t op = 0; op < static_cast<std::size_t>(Operator::count_); ++op)
    EXPECT_GT(counts(static_cast<Operator>(op), Verdict::accepted), 0u)
        << kOperatorNames[op] << " was never accepted";
}

TEST(KernelProperty, RandomOperatorsKeepAJitteredBox) {
  OperationCounts counts;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    MeshData mesh = support::unit_cube(4);
    support::jitter_interior(mesh, 0.06, seed);
    support::shuffle(mesh, seed);
    shake_and_check(mesh, 0.25, 0.3 * seed, seed, 6, 4000, counts);
  }
  expect_all_operators_acted(counts);
}

TEST(KernelProperty, RandomOperatorsKeepABoxOfOneCell) {
  OperationCounts counts;
  for (unsigned seed = 1; seed <= 4; ++seed)
    shake_and_check(support::unit_cube(1), 0.6, 0.4, seed, 6, 1500, counts);
  expect_all_operators_acted(counts);
}

TEST(KernelProperty, RandomOperatorsKeepTwoMaterials) {
  OperationCounts counts;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    MeshData mesh = support::layered_box(3, 3, 2);
    support::jitter_interior(mesh, 0.05, seed);
    support::shuffle(mesh, seed);
    shake_and_check(mesh, 0.3, 0.6, seed, 6, 4000, counts);
  }
  expect_all_operators_acted(counts);
}

TEST(KernelProperty, RandomOperatorsKeepThreeThinMaterials) {
  OperationCounts counts;
  for (unsigned seed = 1; seed <= 2; ++seed)
    shake_and_check(support::layered_box(3, 1, 3), 0.4, 0.6, seed, 6, 4000, counts);
  expect_all_operators_acted(counts);
}

TEST(KernelProperty, RequiredEntitiesStayAsTheyAre) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    MeshData mesh = support::unit_cube(4);
    support::jitter_interior(mesh, 0.05, seed);
    std::mt19937 random(seed);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (random() % 10 == 0) mesh.required_triangles.push_back(t);
    for (std::uint32_t e = 0; e < mesh.edges.size(); ++e)
      if (random() % 5 == 0) mesh.required_edges.push_back(e);
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
      if (random() % 12 == 0) mesh.required_points.push_back(v);
    KernelRig rig(mesh, random_field(mesh, 0.25, 0.5, random));
    loosen(rig.kernel.limits);
    Shaker shaker(rig.worker, seed);
    for (int batch = 0; batch < 4; ++batch) {
      shaker.shake(4000);
      expect_sound(rig.mesh);
      const MeshData data = rig.export_data();
      expect_same_domain(data, mesh);
      const auto places = [](const MeshData& m, const auto& entity) {
        std::vector<std::array<double, 3>> x;
        for (const std::uint32_t v : entity) x.push_back({m.points[v].x, m.points[v].y, m.points[v].z});
        std::sort(x.begin(), x.end());
        return x;
      };
      std::set<std::vector<std::array<double, 3>>> triangles, edges, points;
      for (const std::uint32_t t : data.required_triangles) triangles.insert(places(data, data.triangles[t]));
      for (const std::uint32_t e : data.required_edges) edges.insert(places(data, data.edges[e]));
      for (const std::uint32_t v : data.required_points) points.insert(places(data, std::array{v}));
      for (const std::uint32_t t : mesh.required_triangles)
        EXPECT_TRUE(triangles.contains(places(mesh, mesh.triangles[t]))) << "triangle " << t + 1;
      for (const std::uint32_t e : mesh.required_edges)
        EXPECT_TRUE(edges.contains(places(mesh, mesh.edges[e]))) << "edge " << e + 1;
      for (const std::uint32_t v : mesh.required_points)
        EXPECT_TRUE(points.contains(places(mesh, std::array{v}))) << "point " << v + 1;
      EXPECT_EQ(data.required_triangles.size(), mesh.required_triangles.size());
      EXPECT_EQ(data.required_points.size(), mesh.required_points.size());
    }
  }
}

TEST(KernelProperty, FrozenVerticesNeverChange) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    MeshData mesh = support::layered_box(3, 2, 2);
    support::jitter_interior(mesh, 0.05, seed);
    std::mt19937 random(seed);
    KernelRig rig(mesh, random_field(mesh, 0.25, 0.5, random));
    loosen(rig.kernel.limits);
    struct Frozen {
      Point x;
      LogMetric metric;
      VertexKind kind;
    };
    std::vector<Frozen> frozen;
    for (const VertexId v : rig.live_vertices()) {
      if (random() % 6 != 0) continue;
      rig.mesh.freeze(v);
      frozen.push_back({rig.mesh.point(v), rig.mesh.log_metric(v), rig.mesh.kind(v)});
    }
    ASSERT_GT(frozen.size(), 5u);
    Shaker shaker(rig.worker, seed);
    shaker.shake(10000);
    expect_sound(rig.mesh);
    expect_same_domain(rig.export_data(), mesh);
    std::size_t still = 0;
    for (const VertexId v : rig.live_vertices()) still += rig.mesh.frozen(v);
    EXPECT_EQ(still, frozen.size());
    for (const Frozen& f : frozen) {
      const VertexId v = rig.vertex_at(f.x);
      EXPECT_TRUE(rig.mesh.frozen(v));
      EXPECT_EQ(rig.mesh.point(v), f.x);
      EXPECT_EQ(rig.mesh.log_metric(v), f.metric);
      EXPECT_EQ(rig.mesh.kind(v), f.kind);
    }
    EXPECT_GT(shaker.counts(Operator::collapse, Verdict::frozen), 0u);
    EXPECT_GT(shaker.counts(Operator::split, Verdict::accepted), 0u);
  }
}

TEST(KernelProperty, WhereEverythingIsFrozenNothingHappens) {
  MeshData mesh = support::unit_cube(3);
  KernelRig rig(mesh, 0.1);
  for (const VertexId v : rig.live_vertices()) rig.mesh.freeze(v);
  rig.kernel.policy.frozen = FrozenPolicy::untouchable;
  Shaker shaker(rig.worker, 1);
  shaker.shake(2000);
  for (std::size_t op = 0; op < static_cast<std::size_t>(Operator::count_); ++op)
    EXPECT_EQ(shaker.counts(static_cast<Operator>(op), Verdict::accepted), 0u) << kOperatorNames[op];
  EXPECT_EQ(rig.live_tets().size(), mesh.tets.size());
}

/// Curved boundaries: conforming, one component, the boundary of the same genus; volume near.
TEST(KernelProperty, RandomOperatorsKeepABallABall) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    MeshData mesh = support::ball(2, 3);
    std::mt19937 random(seed);
    KernelRig rig(mesh, random_field(mesh, 0.3, 0.5, random));
    loosen(rig.kernel.limits);
    rig.kernel.limits.hausd = 0.02;
    Shaker shaker(rig.worker, seed);
    for (int batch = 0; batch < 6; ++batch) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", batch " + std::to_string(batch));
      shaker.shake(4000);
      expect_sound(rig.mesh);
      const MeshData data = rig.export_data();
      const CheckReport report = check_mesh(data);
      for (const auto& problem : report.problems) ADD_FAILURE() << problem;
      EXPECT_EQ(report.num_components, 1u);
      EXPECT_NEAR(report.volume, 4 * std::numbers::pi / 3, 0.2);
      std::set<std::uint32_t> boundary;
      for (const auto& t : data.triangles) boundary.insert(t.begin(), t.end());
      EXPECT_EQ(2 * boundary.size(), 4 + data.triangles.size()) << "no sphere";
      for (const std::uint32_t v : boundary) EXPECT_NEAR(norm(data.points[v]), 1, 0.01);
    }
    expect_all_operators_acted(shaker.counts);
  }
}

/// A smooth body with a narrow tunnel: collapses of its boundary must not close it (the link condition).
TEST(KernelProperty, RandomOperatorsKeepATunnelOpen) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    MeshData box = support::unit_cube(5);
    MeshData mesh;
    mesh.points = box.points;
    mesh.point_refs = box.point_refs;
    for (const auto& tet : box.tets) {
      Point centre;
      for (const std::uint32_t v : tet) centre += 0.25 * box.points[v];
      if (std::max(std::abs(centre.x - 0.5), std::abs(centre.y - 0.5)) < 0.1) continue;
      mesh.tets.push_back(tet);
    }
    mesh.tet_refs.assign(mesh.tets.size(), 1);
    support::add_boundary_triangles(mesh);
    KernelRig rig(mesh, 0.6, 179);
    loosen(rig.kernel.limits);
    rig.kernel.limits.hausd = 1;
    Shaker shaker(rig.worker, seed);
    for (int batch = 0; batch < 4; ++batch) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", batch " + std::to_string(batch));
      shaker.shake(3000);
      expect_sound(rig.mesh);
      const MeshData data = rig.export_data();
      const CheckReport report = check_mesh(data);
      for (const auto& problem : report.problems) ADD_FAILURE() << problem;
      EXPECT_EQ(report.num_components, 1u);
      std::set<std::uint32_t> boundary;
      for (const auto& t : data.triangles) boundary.insert(t.begin(), t.end());
      EXPECT_EQ(2 * boundary.size(), data.triangles.size()) << "no torus";
    }
    EXPECT_GT(shaker.counts(Operator::collapse, Verdict::accepted), 0u);
  }
}

/// Several threads on a mesh so small that they meet all the time.
TEST(KernelProperty, ThreadsThatMeetDoNoHarm) {
  constexpr int kThreads = 4;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    MeshData mesh = support::layered_box(3, 3, 2);
    support::jitter_interior(mesh, 0.04, seed);
    std::mt19937 random(seed);
    KernelRig rig(mesh, random_field(mesh, 0.25, 0.4, random));
    loosen(rig.kernel.limits);
    rig.mesh.freeze(rig.vertex_at({0.5, 0.5, 0.5}));
    std::vector<std::unique_ptr<Worker>> workers;
    std::vector<std::unique_ptr<Shaker>> shakers;
    for (unsigned i = 0; i < kThreads; ++i) {
      workers.push_back(std::make_unique<Worker>(rig.kernel, i + 2, false));
      shakers.push_back(std::make_unique<Shaker>(*workers.back(), kThreads * seed + i));
    }
    {
      std::vector<std::jthread> threads;
      for (const auto& shaker : shakers) threads.emplace_back([&shaker] { shaker->shake(4000); });
    }
    OperationCounts counts;
    for (const auto& shaker : shakers) counts += shaker->counts;
    expect_all_operators_acted(counts);
    expect_sound(rig.mesh);
    expect_metrics_of_the_background(rig);
    expect_same_domain(rig.export_data(), mesh);
  }
}

/// The passes as the driver runs them, with more threads than cores.
TEST(KernelProperty, PassesOfManyThreadsDoNoHarm) {
  for (const int threads : {2, 7}) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    MeshData mesh = support::layered_box(6, 6, 2);
    support::jitter_interior(mesh, 0.03);
    std::mt19937 random(9);
    KernelRig rig(mesh, random_field(mesh, 0.1, 0.4, random));
    WorkerPool pool(rig.kernel, threads, nullptr);
    for (int round = 0; round < 4; ++round) {
      for (const TetId t : rig.live_tets()) rig.mesh.mark(t, kAllTetMarks);
      for (const VertexId v : rig.live_vertices()) rig.mesh.mark(v, kCheckShort | kCheckPlace);
      split_pass(pool);
      collapse_pass(pool);
      swap_pass(pool, 0.9);
      smooth_pass(pool);
      improve_pass(pool, 0.5);
      expect_sound(rig.mesh);
      EXPECT_EQ(rig.live_tets().size(), pool.live_tets());
      EXPECT_EQ(rig.live_vertices().size(), pool.live_vertices());
    }
    EXPECT_GT(rig.live_tets().size(), 4 * 2048u) << "too small for several threads";
    expect_all_operators_acted(pool.take_counts());
    expect_same_domain(rig.export_data(), mesh);
  }
}

}  // namespace
}  // namespace weft::meshing::kernel_property_test

// Tests of a whole adaptation: validity, quality, reproducibility, odd requests and bad input.
#include "meshing/adapt/adapt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "meshing/adapt/passes.h"
#include "meshing/adapt/stages.h"
#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_field.h"
#include "meshing/operators/collapse_edge.h"
#include "tests/support/case_files.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"
#include "tests/support/repetitions.h"

namespace weft::meshing::adapt_test {
namespace {

using support::case_files;
using support::expect_same_domain;
using support::KernelRig;
using support::uniform_metric;
using support::unit_cube;
using testing::HasSubstr;

AdaptResult adapted(const MeshData& mesh, const LogMetricField& metric, AdaptOptions options = {}) {
  return adapt(mesh, {&mesh, &metric}, options);
}

AdaptOptions with_threads(int threads) {
  AdaptOptions options;
  options.threads = threads;
  return options;
}

/// A plane layer at x = 0.5: sizes along x from 0.02 to 0.2, 0.2 across.
LogMetric layer(const Point& p) {
  const double h = 0.02 + 0.36 * std::abs(p.x - 0.5), across = 0.2;
  return {-2 * std::log(h), 0, -2 * std::log(across), 0, 0, -2 * std::log(across)};
}

template <class F>
LogMetricField sampled(const MeshData& mesh, F f) {
  LogMetricField field;
  for (const Point& p : mesh.points) field.push_back(f(p));
  return field;
}

/// All arrays equal to the last bit.
bool same_bytes(const MeshData& a, const MeshData& b) {
  const auto bits = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0);
  };
  return bits(a.points, b.points) && bits(a.point_refs, b.point_refs) && bits(a.tets, b.tets) &&
         bits(a.tet_refs, b.tet_refs) && bits(a.triangles, b.triangles) &&
         bits(a.triangle_refs, b.triangle_refs) && bits(a.edges, b.edges) && bits(a.edge_refs, b.edge_refs) &&
         bits(a.corners, b.corners) && bits(a.required_points, b.required_points) &&
         bits(a.ridges, b.ridges) && bits(a.required_edges, b.required_edges) &&
         bits(a.required_triangles, b.required_triangles);
}

void expect_metric_of_the_background(const AdaptResult& result, const MeshData& mesh,
                                     const LogMetricField& metric) {
  ASSERT_EQ(result.log_metrics.size(), result.mesh.points.size());
  const Background background(mesh, metric, build_adjacency(mesh.tets, mesh.points.size()));
  for (std::size_t v = 0; v < result.mesh.points.size(); ++v) {
    const SymTensor d =
        result.log_metrics[v] - background.at(result.mesh.points[v], Background::kNoHint).log_metric;
    EXPECT_LT(
        std::abs(d.xx) + std::abs(d.yy) + std::abs(d.zz) + std::abs(d.xy) + std::abs(d.xz) + std::abs(d.yz),
        1e-8);
  }
}

struct Floors {
  double mean, q01, least, unit;
};

void expect_good(const AdaptResult& result, const Floors& floors) {
  const Measures m = measure(result.mesh, result.log_metrics);
  EXPECT_GE(m.quality_mean, floors.mean);
  EXPECT_GE(m.quality_q01, floors.q01);
  EXPECT_GE(m.quality_min, floors.least);
  EXPECT_GE(m.edges_unit, floors.unit);
}

std::string refusal(const MeshData& mesh) {
  const LogMetricField metric = uniform_metric(mesh, 0.5);
  try {
    adapted(mesh, metric);
  } catch (const InputError& e) {
    return e.what();
  }
  return "not refused";
}

// --- the main job ---

class AdaptThreads : public testing::TestWithParam<int> {};

TEST_P(AdaptThreads, AUniformMetricFillsTheCube) {
  const MeshData mesh = unit_cube(4);
  const LogMetricField metric = uniform_metric(mesh, 0.1);
  const AdaptResult result = adapted(mesh, metric, with_threads(GetParam()));
  expect_same_domain(result.mesh, mesh);
  support::expect_same_lengths(result.mesh, mesh);
  expect_good(result, {0.80, 0.50, 0.20, 0.93});
  EXPECT_NEAR(complexity(result.mesh, result.log_metrics), 1000, 50);
  expect_metric_of_the_background(result, mesh, metric);
  EXPECT_FALSE(result.report.interrupted);
  EXPECT_TRUE(result.report.warnings.empty());
}

TEST_P(AdaptThreads, AnAnisotropicLayerIsResolved) {
  const MeshData mesh = unit_cube(12);
  const LogMetricField metric = sampled(mesh, layer);
  const double target = complexity(mesh, metric);
  const AdaptResult result = adapted(mesh, metric, with_threads(GetParam()));
  expect_same_domain(result.mesh, mesh);
  support::expect_same_lengths(result.mesh, mesh);
  expect_good(result, {0.75, 0.40, 0.10, 0.88});
  EXPECT_NEAR(complexity(result.mesh, result.log_metrics), target, 0.05 * target);
  expect_metric_of_the_background(result, mesh, metric);
}

TEST_P(AdaptThreads, ACoarseMetricEmptiesTheCube) {
  const MeshData mesh = unit_cube(10);
  const LogMetricField metric = uniform_metric(mesh, 0.4);
  const AdaptResult result = adapted(mesh, metric, with_threads(GetParam()));
  expect_same_domain(result.mesh, mesh);
  EXPECT_LT(result.mesh.tets.size(), mesh.tets.size() / 10);
  expect_good(result, {0.6, 0.2, 0.1, 0.6});
}

TEST_P(AdaptThreads, MaterialsKeepTheirVolumesWhereTheirInterfacesArePlanar) {
  MeshData mesh = support::layered_box(4, 2, 3);
  support::jitter_interior(mesh, 0.03);
  support::shuffle(mesh);
  for (const double size : {0.1, 0.5}) {
    const LogMetricField metric = uniform_metric(mesh, size);
    const AdaptResult result = adapted(mesh, metric, with_threads(GetParam()));
    expect_same_domain(result.mesh, mesh);
    support::expect_same_lengths(result.mesh, mesh);
    if (size < 0.2) expect_good(result, {0.78, 0.40, 0.15, 0.90});
  }
}

TEST_P(AdaptThreads, BodiesThatTouchThemselvesKeepTheirShape) {
  for (const unsigned seed : {1u, 2u, 5u, 11u, 17u}) {
    MeshData mesh = support::touching_cells(4, seed);
    support::jitter_interior(mesh, 0.02, seed);
    support::shuffle(mesh, seed);
    for (const double size : {0.12, 0.4}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", size " << size);
      const AdaptResult result = adapted(mesh, uniform_metric(mesh, size), with_threads(GetParam()));
      expect_same_domain(result.mesh, mesh);
      EXPECT_THAT(result.report.warnings, testing::Contains(HasSubstr("touches itself")));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, AdaptThreads, testing::Values(1, 2, 7),
                         [](const auto& param_info) { return std::to_string(param_info.param) + "threads"; });

TEST(Adapt, OneThreadGivesTheSameBytesTwice) {
  MeshData mesh = unit_cube(6);
  support::jitter_interior(mesh, 0.03);
  support::shuffle(mesh);
  const LogMetricField metric = sampled(mesh, layer);
  const AdaptResult first = adapted(mesh, metric), second = adapted(mesh, metric);
  EXPECT_TRUE(same_bytes(first.mesh, second.mesh));
  EXPECT_EQ(first.log_metrics, second.log_metrics);
}

TEST(Adapt, OfABallKeepsToTheSameBytes) {
  const MeshData mesh = support::ball(1, 2);
  const LogMetricField metric = uniform_metric(mesh, 0.3);
  EXPECT_TRUE(same_bytes(adapted(mesh, metric).mesh, adapted(mesh, metric).mesh));
}

TEST(Adapt, AResultAdaptedAgainStaysNearlyAsItIs) {
  const MeshData mesh = unit_cube(4);
  const LogMetricField metric = uniform_metric(mesh, 0.12);
  const AdaptResult first = adapted(mesh, metric);
  const AdaptResult again = adapt(first.mesh, {&mesh, &metric}, {});
  expect_same_domain(again.mesh, mesh);
  const auto before = static_cast<double>(first.mesh.tets.size());
  EXPECT_NEAR(static_cast<double>(again.mesh.tets.size()), before, 0.02 * before);
  const auto accepted = [](const AdaptReport& r, Operator op) {
    return static_cast<double>(r.counts(op, Verdict::accepted));
  };
  EXPECT_LT(accepted(again.report, Operator::split), 0.01 * before);
  EXPECT_LT(accepted(again.report, Operator::collapse), 0.01 * before);
  const auto same = [&] {
    std::set<std::array<double, 3>> old;
    for (const Point& p : first.mesh.points) old.insert({p.x, p.y, p.z});
    std::size_t kept = 0;
    for (const Point& p : again.mesh.points) kept += old.contains({p.x, p.y, p.z});
    return static_cast<double>(kept);
  };
  EXPECT_GT(same(), 0.8 * static_cast<double>(first.mesh.points.size()));
}

TEST(Adapt, ReadsTheMetricFromABackgroundThatIsNotTheInput) {
  const MeshData background = unit_cube(12), mesh = unit_cube(2);
  const LogMetricField metric = sampled(background, layer);
  const AdaptResult result = adapt(mesh, {&background, &metric}, {});
  expect_same_domain(result.mesh, mesh);
  expect_metric_of_the_background(result, background, metric);
  const double target = complexity(background, metric);
  EXPECT_NEAR(complexity(result.mesh, result.log_metrics), target, 0.05 * target);
  expect_good(result, {0.75, 0.40, 0.10, 0.88});
}

TEST(Adapt, TellsWhatItDid) {
  const MeshData mesh = unit_cube(3);
  const LogMetricField metric = uniform_metric(mesh, 0.1);
  AdaptOptions options;
  double last = 0;
  int calls = 0;
  options.progress = [&](const std::string& stage, double done, std::uint64_t tets) {
    EXPECT_FALSE(stage.empty());
    EXPECT_GE(done, last);
    EXPECT_LE(done, 1);
    EXPECT_GT(tets, 0u);
    last = done;
    ++calls;
  };
  const AdaptResult result = adapted(mesh, metric, options);
  EXPECT_GT(calls, 1);
  ASSERT_FALSE(result.report.stages.empty());
  OperationCounts sum;
  for (const StageReport& s : result.report.stages) sum += s.counts;
  EXPECT_EQ(sum.of, result.report.counts.of);
  const StageReport& end = result.report.stages.back();
  EXPECT_EQ(end.tets, result.mesh.tets.size());
  EXPECT_EQ(end.vertices, result.mesh.points.size());
  // Each accepted split is one vertex more, each collapse one less.
  EXPECT_EQ(mesh.points.size() + sum(Operator::split, Verdict::accepted),
            result.mesh.points.size() + sum(Operator::collapse, Verdict::accepted));
}

// --- requests at the edge of sense ---

TEST(Adapt, OneTetStaysOneWhereItIsRight) {
  const MeshData mesh = support::regular_tet();
  for (const double size : {1.0, 50.0}) {
    const AdaptResult result = adapted(mesh, uniform_metric(mesh, size));
    expect_same_domain(result.mesh, mesh);
    EXPECT_EQ(result.mesh.tets.size(), 1u);
    EXPECT_EQ(result.mesh.points.size(), 4u);
  }
}

TEST(Adapt, OneTetIsRefined) {
  const MeshData mesh = support::regular_tet();
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.1));
  expect_same_domain(result.mesh, mesh);
  expect_good(result, {0.75, 0.4, 0.1, 0.88});
}

TEST(Adapt, TwoTetsAreRefined) {
  const MeshData mesh = support::two_tets();
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.15));
  expect_same_domain(result.mesh, mesh);
  EXPECT_GT(result.mesh.tets.size(), 200u);
}

TEST(Adapt, HugeSizesLeaveAValidCoarseMesh) {
  const MeshData mesh = unit_cube(5);
  for (const double size : {10.0, 1e5, 1e10, 1e50}) {
    SCOPED_TRACE(size);
    const AdaptResult result = adapted(mesh, uniform_metric(mesh, size));
    expect_same_domain(result.mesh, mesh);
    EXPECT_LT(result.mesh.tets.size(), 100u);
  }
}

TEST(Adapt, TinyMetersAreAsGoodAsLargeOnes) {
  // The same request in other units gives a mesh as good.
  for (const double unit : {1e-9, 1e-3, 1e6}) {
    SCOPED_TRACE(unit);
    MeshData mesh = unit_cube(4);
    for (Point& p : mesh.points) p = unit * p;
    const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.12 * unit));
    const CheckReport report = check_mesh(result.mesh);
    EXPECT_TRUE(report.ok());
    EXPECT_NEAR(report.volume / (unit * unit * unit), 1, 1e-9);
    expect_good(result, {0.78, 0.45, 0.15, 0.90});
  }
}

/// Of the points that two meshes share, those that come after the one before them in both.
double share_in_order(const MeshData& mesh, const MeshData& old) {
  std::map<std::array<double, 3>, std::size_t> places;
  for (const Point& p : old.points) places[{p.x, p.y, p.z}] = places.size();
  double shared = 0, ascending = 0, last = -1;
  for (const Point& p : mesh.points) {
    const auto found = places.find({p.x, p.y, p.z});
    if (found == places.end()) continue;
    const auto place = static_cast<double>(found->second);
    ++shared;
    ascending += place > last;
    last = place;
  }
  EXPECT_GT(shared, 0.8 * static_cast<double>(old.points.size()));
  return ascending / shared;
}

TEST(Adapt, AMeshThatConformsStaysInItsOrder) {
  const MeshData cube = unit_cube(6);
  AdaptResult first = adapted(cube, uniform_metric(cube, 0.07));
  const AdaptResult again = adapted(first.mesh, first.log_metrics);
  EXPECT_GT(share_in_order(again.mesh, first.mesh), 0.98);
  expect_same_domain(again.mesh, cube);
  expect_good(again, {0.85, 0.65, 0.40, 0.97});
  support::shuffle(first.mesh);
  const AdaptResult ordered = adapted(first.mesh, uniform_metric(first.mesh, 0.07));
  EXPECT_LT(share_in_order(ordered.mesh, first.mesh), 0.7);
}

TEST(Adapt, AMetricThatChangedInOneCornerIsFollowedThere) {
  const MeshData cube = unit_cube(6);
  const AdaptResult first = adapted(cube, uniform_metric(cube, 0.07));
  LogMetricField metric = first.log_metrics;
  for (std::size_t v = 0; v < metric.size(); ++v)
    if (norm(first.mesh.points[v]) < 0.2) metric[v] = metric[v] + LogMetric(identity_tensor(2 * std::log(2)));
  const AdaptResult result = adapted(first.mesh, metric);
  EXPECT_NEAR(complexity(result.mesh, result.log_metrics), complexity(first.mesh, metric), 100);
  EXPECT_GT(result.mesh.tets.size(), first.mesh.tets.size());
  expect_same_domain(result.mesh, cube);
  expect_good(result, {0.85, 0.60, 0.30, 0.95});
}

TEST(Adapt, AMeshThatBecomesFullGrows) {
  const MeshData input = unit_cube(3);
  for (const int threads : {1, 3}) {
    const LogMetricField metric = uniform_metric(input, 0.08);
    ImportedMesh imported = import_mesh(input, 45, 2000, 4000);
    const Background background(input, metric, build_adjacency(input.tets, input.points.size()));
    read_metric(*imported.mesh, background, true);
    Kernel kernel{*imported.mesh, background, *imported.surface, {}};
    AdaptReport report;
    adapt_in_place(kernel, with_threads(threads), Extent::everything, report);
    EXPECT_TRUE(report.warnings.empty());
    EXPECT_FALSE(imported.mesh->is_full());
    MeshData result;
    LogMetricField metrics;
    export_mesh(*imported.mesh, *imported.surface, imported.patch_required, result, metrics);
    EXPECT_GT(result.tets.size(), 9000u);
    EXPECT_GT(measure(result, metrics).edges_unit, 0.95);
    expect_same_domain(result, input);
  }
}

/// How many tets passes of splits make of `input`, in a mesh that has room for `tets` at first.
std::size_t tets_of_split(const MeshData& input, std::size_t vertices, std::size_t tets) {
  const LogMetricField metric = uniform_metric(input, 0.06);
  ImportedMesh imported = import_mesh(input, 45, vertices, tets);
  const Background background(input, metric, build_adjacency(input.tets, input.points.size()));
  read_metric(*imported.mesh, background, true);
  TetMesh& mesh = *imported.mesh;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    mesh.set_quality(TetId(i),
                     static_cast<float>(judge_quality(Policy().mean, mesh, mesh.vertices(TetId(i)))));
    mesh.mark(TetId(i), kCheckLong);
  }
  Kernel kernel{mesh, background, *imported.surface, {}};
  WorkerPool pool(kernel, 1, nullptr);
  while (split_pass(pool) > 0 || (mesh.is_full() && mesh.grow())) continue;
  return pool.live_tets();
}

/// What a pass came to after the mesh had become full is split as well.
TEST(Adapt, PassesThatLackedRoomForgetNothing) {
  const MeshData input = unit_cube(8);
  const std::size_t points = input.points.size(), tets = input.tets.size();
  const std::size_t ample = tets_of_split(input, 100 * points, 100 * tets);
  ASSERT_GT(ample, 3 * tets);
  EXPECT_NEAR(static_cast<double>(tets_of_split(input, 100 * points, tets + tets / 4)),
              static_cast<double>(ample), 0.05 * static_cast<double>(ample));
}

/// Needles along an inner edge 42 long, the middle one of three on an axis: what divides them leaves tets
/// worse than .8 of them.
TEST(Adapt, ANeedleFarTooLongIsDividedThoughItsPartsAreWorse) {
  std::vector<Point> points{{0, 0, -2}, {0, 0, 40}, {0, 0, -4}, {0, 0, 60}};
  for (const auto& [x, y] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}})
    points.push_back({static_cast<double>(x), static_cast<double>(y), 0});
  std::vector<Tet> tets;
  for (const auto& [below, above] : {std::pair{2u, 0u}, {0u, 1u}, {1u, 3u}})
    for (std::uint32_t i = 0; i < 4; ++i) tets.push_back({below, above, 4 + i, 4 + (i + 1) % 4});
  KernelRig rig(support::mesh_of(std::move(points), std::move(tets)), 1, support::kFaceted);
  ASSERT_EQ(rig.mesh.kind(VertexId(0)), VertexKind::interior);
  for (const TetId t : rig.live_tets()) {
    if (rig.mesh.local_index(t, VertexId(0)) < 0 || rig.mesh.local_index(t, VertexId(1)) < 0) continue;
    EXPECT_LT(rig.mesh.quality(t), rig.kernel.limits.split_quality);
    rig.mesh.mark(t, kCheckLong);
  }
  WorkerPool pool(rig.kernel, 1, nullptr);
  split_pass(pool);
  EXPECT_THAT(rig.neighbours_of(VertexId(0)), testing::Not(testing::Contains(VertexId(1))));
  support::expect_sound(rig.mesh);
}

TEST(Adapt, CountsWhatIsDeadFromBefore) {
  KernelRig rig(unit_cube(4));
  ASSERT_EQ(gather_ball(rig.mesh, rig.worker.claims, rig.vertex_at({0.5, 0.5, 0.5}), rig.worker.ball),
            Verdict::accepted);
  rig.kernel.limits.collapse_longest = 10;
  rig.kernel.limits.collapse_quality = 0;
  Verdict collapsed = Verdict::not_needed;
  for (const VertexId v : rig.neighbours_of(rig.worker.ball.centre))
    if (collapsed != Verdict::accepted)
      collapsed = collapse_edge(rig.worker, rig.worker.ball.centre, v, CollapseGoal::length);
  ASSERT_EQ(collapsed, Verdict::accepted);
  rig.worker.claims.release();
  const WorkerPool pool(rig.kernel, 1, nullptr);
  EXPECT_EQ(pool.live_tets(), rig.live_tets().size());
  EXPECT_EQ(pool.live_vertices(), rig.live_vertices().size());
}

TEST(Adapt, MoreThreadsThanCoresOrNoneIsFine) {
  const MeshData mesh = unit_cube(3);
  for (const int threads : {-1, 0, 64}) {
    const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.2), with_threads(threads));
    expect_same_domain(result.mesh, mesh);
  }
}

TEST(Adapt, InterruptedBeforeTheStartGivesTheInput) {
  const MeshData mesh = unit_cube(4);
  const std::atomic<bool> interrupt = true;
  AdaptOptions options;
  options.interrupt = &interrupt;
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.05), options);
  EXPECT_TRUE(result.report.interrupted);
  expect_same_domain(result.mesh, mesh);
  EXPECT_EQ(result.mesh.tets.size(), mesh.tets.size());
  EXPECT_EQ(result.log_metrics.size(), result.mesh.points.size());
}

TEST(Adapt, InterruptedOnTheWayGivesAValidMesh) {
  const MeshData mesh = unit_cube(4);
  for (const int threads : {1, 2})
    for (const int calls : {1, 2, 5, 8}) {
      std::atomic<bool> interrupt = false;
      int seen = 0;
      AdaptOptions options = with_threads(threads);
      options.interrupt = &interrupt;
      options.progress = [&](const std::string&, double, std::uint64_t) { interrupt = ++seen >= calls; };
      const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.08), options);
      EXPECT_TRUE(result.report.interrupted);
      expect_same_domain(result.mesh, mesh);
      EXPECT_EQ(result.log_metrics.size(), result.mesh.points.size());
    }
}

TEST(Adapt, InterruptedItIsNotPutInOrderOnTheWayOut) {
  MeshData mesh = unit_cube(4);
  std::mt19937 random(3);
  std::shuffle(mesh.tets.begin(), mesh.tets.end(), random);
  const std::atomic<bool> interrupt = true;
  AdaptOptions options = with_threads(1);
  options.interrupt = &interrupt;
  const AdaptResult early = adapted(mesh, uniform_metric(mesh, 0.2), options);
  EXPECT_FALSE(early.report.in_order);
  EXPECT_TRUE(early.mesh.points == mesh.points) << "points keep their numbers";
}

// --- bad input ---

std::uint64_t done(const AdaptResult& result, std::initializer_list<Operator> operators) {
  std::uint64_t sum = 0;
  for (const Operator op : operators) sum += result.report.counts(op, Verdict::accepted);
  return sum;
}

/// Coordinates of all vertices, in the order of their values.
std::vector<std::array<double, 3>> places(const MeshData& mesh) {
  std::vector<std::array<double, 3>> all;
  for (const Point& p : mesh.points) all.push_back({p.x, p.y, p.z});
  std::sort(all.begin(), all.end());
  return all;
}

TEST(AdaptAllowed, WithoutInsertionTheVerticesStayAndMove) {
  const MeshData cube = unit_cube(6);
  AdaptOptions options;
  options.allowed.insert = false;
  const AdaptResult result = adapted(cube, sampled(cube, layer), options);
  expect_same_domain(result.mesh, cube);
  EXPECT_EQ(result.mesh.points.size(), cube.points.size());
  EXPECT_EQ(done(result, {Operator::split, Operator::collapse}), 0);
  EXPECT_GT(done(result, {Operator::swap_edge}), 0);
  EXPECT_GT(done(result, {Operator::smooth}), 0);
}

TEST(AdaptAllowed, WithoutMovementVerticesComeAndGoButDoNotMove) {
  const MeshData cube = unit_cube(6);
  AdaptOptions options;
  options.allowed.move = false;
  const AdaptResult result = adapted(cube, sampled(cube, layer), options);
  expect_same_domain(result.mesh, cube);
  EXPECT_EQ(done(result, {Operator::smooth, Operator::relocate}), 0);
  EXPECT_GT(result.mesh.points.size(), cube.points.size());
}

TEST(AdaptAllowed, WithoutSwapsThereAreNone) {
  const MeshData cube = unit_cube(6);
  AdaptOptions options;
  options.allowed.swap = false;
  const AdaptResult result = adapted(cube, sampled(cube, layer), options);
  expect_same_domain(result.mesh, cube);
  EXPECT_EQ(done(result, {Operator::swap_edge, Operator::swap_face}), 0);
  EXPECT_GT(done(result, {Operator::split}), 0);
}

TEST(AdaptAllowed, WithSwapsAloneEveryVertexStaysWhereItIs) {
  const MeshData cube = unit_cube(6);
  AdaptOptions options;
  options.allowed = {.insert = false, .swap = true, .move = false};
  // Small along the diagonals that the cells' faces have in the plane z = 0, large across.
  const double small = -2 * std::log(0.05), large = -2 * std::log(0.4), mean = (small + large) / 2;
  const LogMetric along_diagonals{mean, (small - large) / 2, mean, 0, 0, large};
  const AdaptResult result = adapted(cube, LogMetricField(cube.points.size(), along_diagonals), options);
  expect_same_domain(result.mesh, cube);
  EXPECT_EQ(places(result.mesh), places(cube));
  EXPECT_GT(done(result, {Operator::swap_edge, Operator::swap_face}), 0);
}

TEST(AdaptInput, NoTets) {
  MeshData mesh;
  EXPECT_THAT(refusal(mesh), HasSubstr("Tetrahedra"));
}

TEST(AdaptInput, AMetricOfAnotherMesh) {
  const MeshData mesh = unit_cube(2);
  const LogMetricField metric(mesh.points.size() + 1);
  EXPECT_THROW(adapted(mesh, metric), InputError);
}

TEST(AdaptInput, AnInvertedTet) {
  MeshData mesh = unit_cube(2);
  std::swap(mesh.tets[6][0], mesh.tets[6][1]);
  EXPECT_THAT(refusal(mesh), testing::AllOf(HasSubstr("tet 7 "), HasSubstr("inverted")));
}

TEST(AdaptInput, AFlatTet) {
  MeshData mesh = support::two_tets();
  mesh.points[4] = {0.2, 0.2, 0};
  EXPECT_THAT(refusal(mesh), testing::AllOf(HasSubstr("tet 2 "), HasSubstr("flat")));
}

TEST(AdaptInput, DuplicateTets) {
  MeshData mesh = unit_cube(2);
  mesh.tets.push_back(mesh.tets[4]);
  mesh.tet_refs.push_back(1);
  EXPECT_THAT(refusal(mesh), testing::AllOf(HasSubstr("5"), HasSubstr("49")));
  MeshData one = support::regular_tet();
  one.tets.push_back(one.tets[0]);
  one.tet_refs.push_back(1);
  EXPECT_THAT(refusal(one), testing::AllOf(HasSubstr("tets 1 and 2"), HasSubstr("duplicate")));
}

TEST(AdaptInput, TetsThatOverlap) {
  MeshData mesh = support::two_tets();
  mesh.points[4] = {0.1, 0.1, 2};
  mesh.tets[1] = {0, 1, 2, 4};
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  EXPECT_THAT(refusal(mesh), testing::AllOf(HasSubstr("tets 1 and 2"), HasSubstr("overlap")));
}

TEST(AdaptInput, ThreeTetsOnOneFace) {
  MeshData mesh = support::two_tets();
  mesh.points.push_back({0.1, 0.1, 2});
  mesh.point_refs.push_back(0);
  mesh.tets.push_back({0, 1, 2, 5});
  mesh.tet_refs.push_back(1);
  EXPECT_THAT(refusal(mesh), testing::AllOf(HasSubstr("1"), HasSubstr("2"), HasSubstr("3")));
}

TEST(AdaptInput, ATriangleThatIsNoFace) {
  MeshData mesh = unit_cube(2);
  mesh.triangles.push_back({0, 13, 26});
  mesh.triangle_refs.push_back(1);
  EXPECT_THAT(refusal(mesh), HasSubstr("triangle " + std::to_string(mesh.triangles.size())));
}

TEST(AdaptInput, IndicesOutOfRange) {
  const auto with = [](auto change) {
    MeshData mesh = unit_cube(2);
    change(mesh);
    return refusal(mesh);
  };
  EXPECT_THAT(with([](MeshData& m) { m.tets[3][2] = 27; }),
              testing::AllOf(HasSubstr("tet 4"), HasSubstr("28")));
  EXPECT_THAT(with([](MeshData& m) { m.triangles[3][2] = 27; }), HasSubstr("riangle 4"));
  EXPECT_THAT(with([](MeshData& m) { m.corners[0] = 27; }), HasSubstr("orner"));
  EXPECT_THAT(with([](MeshData& m) { m.required_points.push_back(27); }), HasSubstr("equired"));
}

// In a process of its own: an index that is not checked reads anywhere.
TEST(AdaptInput, IndicesOfListedEntitiesOutOfRange) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto refused = [](auto change) {
    MeshData mesh = unit_cube(2);
    change(mesh);
    std::exit(refusal(mesh) == "not refused" ? 1 : 0);
  };
  const testing::ExitedWithCode clean(0);
  EXPECT_EXIT(refused([](MeshData& m) { m.required_triangles.push_back(1000000000); }), clean, "");
  EXPECT_EXIT(refused([](MeshData& m) { m.ridges.push_back(1000000000); }), clean, "");
  EXPECT_EXIT(refused([](MeshData& m) { m.required_edges.push_back(1000000000); }), clean, "");
  EXPECT_EXIT(refused([](MeshData& m) {
                m.edges.push_back({0, 500});
                m.edge_refs.push_back(1);
              }),
              clean, "");
}

TEST(AdaptInput, MissingTrianglesAreCreatedWithAWarning) {
  MeshData mesh = unit_cube(3);
  const LogMetricField metric = uniform_metric(mesh, 0.25);
  MeshData without = mesh;
  without.triangles.resize(without.triangles.size() - 5);
  without.triangle_refs.resize(without.triangles.size());
  const AdaptResult some = adapted(without, metric);
  EXPECT_THAT(some.report.warnings, testing::Contains(testing::AllOf(HasSubstr("5"), HasSubstr("created"))));
  const CheckReport report = check_mesh(some.mesh);
  EXPECT_TRUE(report.ok());
  EXPECT_NEAR(report.volume, 1, 1e-9);
  EXPECT_TRUE(report.area_by_ref.contains(0));
  without.triangles.clear();
  without.triangle_refs.clear();
  const AdaptResult all = adapted(without, metric);
  EXPECT_THAT(all.report.warnings, testing::Contains(HasSubstr("created")));
  EXPECT_TRUE(check_mesh(all.mesh).ok());
  EXPECT_NEAR(check_mesh(all.mesh).area_by_ref.at(0), 6, 1e-8);
}

TEST(AdaptInput, MissingInterfaceTrianglesAreCreatedToo) {
  MeshData mesh = support::layered_box(2, 2, 2);
  for (std::size_t i = mesh.triangles.size(); i-- > 0;)
    if (mesh.triangle_refs[i] > 6) {
      mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(i));
      mesh.triangle_refs.erase(mesh.triangle_refs.begin() + static_cast<std::ptrdiff_t>(i));
    }
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.25));
  EXPECT_THAT(result.report.warnings, testing::Contains(HasSubstr("created")));
  const CheckReport report = check_mesh(result.mesh);
  EXPECT_TRUE(report.ok());
  EXPECT_NEAR(report.volume_by_ref.at(1), 1, 1e-9);
  EXPECT_NEAR(report.volume_by_ref.at(2), 1, 1e-9);
  EXPECT_NEAR(report.area_by_ref.at(0), 1, 1e-9);
}

TEST(AdaptInput, UnusedPointsAreDroppedWithAWarning) {
  MeshData mesh = unit_cube(2);
  mesh.points.push_back({5, 5, 5});
  mesh.point_refs.push_back(0);
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.25));
  EXPECT_THAT(result.report.warnings, testing::Contains(HasSubstr("points")));
  expect_same_domain(result.mesh, unit_cube(2));
}

// --- meshes far from their metric ---

TEST(AdaptFarMesh, ComesOutBetterWhenItIsMadeCoarseFirst) {
  const MeshData mesh = unit_cube(10);
  LogMetricField metric = sample(AnalyticMetric("polar-2"), mesh);
  scale_to_complexity(mesh, 4000, metric);
  AdaptOptions as_it_is;
  as_it_is.coarsen = false;
  const AdaptResult coarse_first = adapted(mesh, metric), direct = adapted(mesh, metric, as_it_is);
  expect_same_domain(coarse_first.mesh, mesh);
  const Measures now = measure(coarse_first.mesh, coarse_first.log_metrics);
  const Measures then = measure(direct.mesh, direct.log_metrics);
  EXPECT_GT(now.quality_q01, 0.98 * then.quality_q01);
  EXPECT_GT(now.quality_mean, then.quality_mean);
  EXPECT_GT(now.edges_unit, then.edges_unit);
  const auto in_vain = [](const AdaptResult& r) {
    return static_cast<double>(r.report.counts(Operator::swap_edge, Verdict::worsens_quality));
  };
  EXPECT_LT(in_vain(coarse_first), 0.8 * in_vain(direct));
}

TEST(AdaptFarMesh, IsNotOneThatFollowsACoarserMetricOfTheSameShape) {
  const MeshData mesh = unit_cube(4);
  LogMetricField metric = sampled(mesh, layer);
  const AdaptResult first = adapted(mesh, metric);
  LogMetricField finer = first.log_metrics;
  for (LogMetric& l : finer)
    for (double* value : {&l.xx, &l.yy, &l.zz}) *value += 2 * std::log(2.5);  // a level more
  AdaptOptions as_it_is;
  as_it_is.coarsen = false;
  EXPECT_TRUE(same_bytes(adapted(first.mesh, finer).mesh, adapted(first.mesh, finer, as_it_is).mesh));
}

// --- frozen vertices ---

TEST(AdaptFrozen, VerticesAreBitIdenticalAfterAllPasses) {
  for (const int threads : {1, 3}) {
    MeshData mesh = unit_cube(5);
    support::jitter_interior(mesh, 0.03);
    KernelRig rig(mesh, sampled(mesh, layer));
    std::vector<Point> frozen;
    for (const VertexId v : rig.live_vertices()) {
      const Point& p = rig.mesh.point(v);
      if (p.x > 0.35) continue;
      rig.mesh.freeze(v);
      frozen.push_back(p);
    }
    WorkerPool pool(rig.kernel, threads, nullptr);
    for (int round = 0; round < 5; ++round) {
      for (const TetId t : rig.live_tets()) rig.mesh.mark(t, kAllTetMarks);
      for (const VertexId v : rig.live_vertices()) rig.mesh.mark(v, kCheckShort | kCheckPlace);
      split_pass(pool);
      collapse_pass(pool);
      swap_pass(pool, 0.8);
      smooth_pass(pool);
      improve_pass(pool, 0.4);
    }
    support::expect_sound(rig.mesh);
    EXPECT_GT(rig.live_tets().size(), mesh.tets.size());
    expect_same_domain(rig.export_data(), mesh);
    for (const Point& p : frozen) {
      const VertexId v = rig.vertex_at(p);
      EXPECT_EQ(rig.mesh.point(v), p);
      EXPECT_TRUE(rig.mesh.frozen(v));
    }
  }
}

// --- curved boundaries ---

/// Boundary vertices lie on the surface that the input's triangulation stands for.
void expect_on_surface(const MeshData& result, const MeshData& input) {
  const Surface surface(input, {});
  std::map<std::int32_t, std::vector<PatchId>> patches;
  for (std::uint32_t p = 0; p < surface.patches().size(); ++p)
    patches[surface.patches()[p].ref].push_back(PatchId(p));
  double worst = 0;
  for (std::size_t i = 0; i < result.triangles.size(); ++i)
    for (const std::uint32_t v : result.triangles[i]) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const PatchId p : patches.at(result.triangle_refs[i]))
        nearest = std::min(
            nearest,
            norm(result.points[v] -
                 surface.project_to_patch(p, result.points[v], VertexKind::interior, 0xFFFFFFFFu).x));
      worst = std::max(worst, nearest);
    }
  EXPECT_LT(worst, 1e-6);
}

TEST(AdaptCurved, ABallBecomesRound) {
  const MeshData mesh = support::ball(2, 3);
  const double exact = 4 * std::numbers::pi / 3;
  ASSERT_GT(exact - check_mesh(mesh).volume, 0.02 * exact);
  for (const int threads : {1, 2}) {
    const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.1), with_threads(threads));
    const CheckReport report = check_mesh(result.mesh);
    for (const auto& problem : report.problems) ADD_FAILURE() << problem;
    EXPECT_EQ(report.num_components, 1u);
    EXPECT_NEAR(report.volume, exact, 0.005 * exact);
    EXPECT_NEAR(report.area_by_ref.at(1), 4 * std::numbers::pi, 0.005 * 4 * std::numbers::pi);
    expect_on_surface(result.mesh, mesh);
    // hausd (0.1 % of the diagonal) is aimed at: a split that would ruin a tet is refused, and the rest
    // reported.
    EXPECT_LE(result.report.surface_deviation, 0.003 * std::sqrt(12.0));
    expect_good(result, {0.75, 0.4, 0.05, 0.88});
    std::set<std::uint32_t> boundary;
    for (const auto& t : result.mesh.triangles) boundary.insert(t.begin(), t.end());
    EXPECT_EQ(2 * boundary.size(), 4 + result.mesh.triangles.size()) << "no sphere";
    for (const std::uint32_t v : boundary) EXPECT_NEAR(norm(result.mesh.points[v]), 1, 2e-3);
  }
}

TEST(AdaptCurved, ACylinderBecomesRoundAndKeepsItsLids) {
  const MeshData mesh = support::cylinder(16, 2, 4, 1);
  ASSERT_TRUE(check_mesh(mesh).ok());
  const double exact = std::numbers::pi;
  ASSERT_GT(exact - check_mesh(mesh).volume, 0.02 * exact);
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.1));
  const CheckReport report = check_mesh(result.mesh);
  for (const auto& problem : report.problems) ADD_FAILURE() << problem;
  EXPECT_NEAR(report.volume, exact, 0.005 * exact);
  EXPECT_NEAR(report.area_by_ref.at(1), 2 * std::numbers::pi, 0.005 * 2 * std::numbers::pi);
  EXPECT_NEAR(report.area_by_ref.at(2), std::numbers::pi, 0.005 * std::numbers::pi);
  EXPECT_NEAR(report.area_by_ref.at(3), std::numbers::pi, 0.005 * std::numbers::pi);
  expect_on_surface(result.mesh, mesh);
  expect_good(result, {0.75, 0.4, 0.05, 0.88});
  for (std::size_t i = 0; i < result.mesh.triangles.size(); ++i)
    for (const std::uint32_t v : result.mesh.triangles[i]) {
      const Point& p = result.mesh.points[v];
      if (result.mesh.triangle_refs[i] == 1) {
        EXPECT_NEAR(std::hypot(p.x, p.y), 1, 2e-3);
      }
      if (result.mesh.triangle_refs[i] == 2) {
        EXPECT_NEAR(p.z, 0, 1e-12);
      }
      if (result.mesh.triangle_refs[i] == 3) {
        EXPECT_NEAR(p.z, 1, 1e-12);
      }
    }
}

/// A quarter of a ring between radii .5 and 1 of n x n x n cells.
MeshData quarter_ring(std::uint32_t n) {
  MeshData mesh = support::unit_cube(n);
  for (Point& p : mesh.points) {
    const double radius = 0.5 + 0.5 * p.x, angle = 0.5 * std::numbers::pi * p.y;
    p = {radius * std::cos(angle), radius * std::sin(angle), p.z};
  }
  return mesh;
}

/// Triangles near the inner cylinder of a quarter ring whose outer side is not towards the axis.
int turned_over(const MeshData& mesh) {
  return static_cast<int>(std::ranges::count_if(mesh.triangles, [&](const auto& t) {
    const Point &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    for (const Point* p : {&a, &b, &c})
      if (std::abs(std::hypot(p->x, p->y) - 0.5) > 0.02) return false;
    const Vec normal = cross(b - a, c - a), middle = (1.0 / 3) * (a + b + c);
    const bool on_plane = std::min(middle.x, middle.y) < 1e-9 || std::min(middle.z, 1 - middle.z) < 1e-9;
    return !on_plane && normal.x * middle.x + normal.y * middle.y > 0;
  }));
}

// Layers along a coarse concave boundary: what is moved there turned triangles over, and the mesh overlapped
// itself in positive tets.
TEST(AdaptCurved, NoTriangleOfTheBoundaryTurnsOver) {
  for (const std::uint32_t n : {3u, 4u, 6u})
    for (const double size : {50, 100, 200, 1000})
      for (const double hausd : {0.03, 0.11}) {
        SCOPED_TRACE(std::to_string(n) + " cells, " + std::to_string(size) + ", " + std::to_string(hausd));
        const MeshData mesh = quarter_ring(n);
        LogMetricField metric = sample(AnalyticMetric("polar-2"), mesh);
        scale_to_complexity(mesh, size, metric);
        AdaptOptions options;
        options.hausd = hausd;
        options.ridge_angle_degrees = 60;
        const AdaptResult result = adapted(mesh, metric, options);
        EXPECT_TRUE(check_mesh(result.mesh).ok());
        EXPECT_EQ(turned_over(result.mesh), 0);
      }
}

TEST(AdaptCurved, ACoarseMetricKeepsABallWithinHausd) {
  const MeshData mesh = support::ball(3, 3);
  AdaptOptions options;
  options.hausd = 0.02;
  const AdaptResult result = adapted(mesh, uniform_metric(mesh, 0.8), options);
  const CheckReport report = check_mesh(result.mesh);
  for (const auto& problem : report.problems) ADD_FAILURE() << problem;
  EXPECT_LT(result.mesh.tets.size(), mesh.tets.size());
  EXPECT_NEAR(report.volume, 4 * std::numbers::pi / 3, 3 * 0.02 * 4 * std::numbers::pi / 3);
  EXPECT_LE(result.report.surface_deviation, 0.021);
  const std::vector<SurfaceDemand>& demands = result.report.surface_demands;
  ASSERT_EQ(demands.size(), 1u);
  EXPECT_EQ(demands[0].ref, 1);
  EXPECT_GT(demands[0].edges, 10u);
  EXPECT_LT(demands[0].allowed, 1);
  EXPECT_GT(demands[0].allowed, 0.2);
  EXPECT_NEAR(norm(demands[0].where), 1, 0.03);
}

TEST(AdaptCurved, AMetricAsFineAsTheSurfaceNeedsContradictsNothing) {
  const MeshData mesh = support::ball(3, 3);
  AdaptOptions options;
  options.hausd = 0.02;
  EXPECT_TRUE(adapted(mesh, uniform_metric(mesh, 0.2), options).report.surface_demands.empty());
  options.hausd = 1;
  EXPECT_TRUE(adapted(mesh, uniform_metric(mesh, 0.8), options).report.surface_demands.empty());
}

// --- real geometry ---

TEST(AdaptCases, TheDeltaWingKeepsThePlanesItIsMadeOf) {
  const MeshData mesh = read_mesh(std::filesystem::path(WEFT_TEST_DATA) / "delta-wing-coarse.meshb");
  for (const double size : {0.5, 3.0}) {
    const AdaptResult result = adapted(mesh, uniform_metric(mesh, size), with_threads(size < 1 ? 1 : 2));
    expect_same_domain(result.mesh, mesh);
    if (size < 1) expect_good(result, {0.6, 0.02, 0.0, 0.6});
  }
}

/// A mesh of the case files with the metric beside it.
struct CaseMesh {
  MeshData mesh;
  LogMetricField metric;
};
CaseMesh case_mesh(const std::filesystem::path& mesh_file, std::filesystem::path metric_file) {
  CaseMesh c{read_mesh(mesh_file), {}};
  c.metric = metric_from_solution(read_solution(metric_file), c.mesh.points.size(), metric_file.string());
  return c;
}

TEST(AdaptCases, CubePolar2ReachesItsFloors) {
  const auto folder = case_files() / "cube-polar2";
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << "NOT TESTED: no case files at " << folder << " (set WEFT_CASES to their folder)";
  auto [mesh, metric] = case_mesh(folder / "start.meshb", folder / "start.solb");
  const double target = support::repetitions(20000, 50000);
  scale_to_complexity(mesh, target, metric);
  const AdaptResult result = adapted(mesh, metric, with_threads(2));
  expect_same_domain(result.mesh, mesh);
  expect_good(result, {0.85, 0.60, 0.20, 0.95});
  EXPECT_NEAR(complexity(result.mesh, result.log_metrics), target, 0.03 * target);
}

/// From 326 tets into a wake that none of their vertices sees: edges up to 9 long and tets of .13 were left
/// where it meets the outer boundary.
TEST(AdaptCases, FromFewTetsNoHeapOfNeedlesIsLeft) {
  const auto folder = case_files() / "delta-wing";
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << "NOT TESTED: no case files at " << folder << " (set WEFT_CASES to their folder)";
  auto [background, metric] = case_mesh(folder / "start.meshb", folder / "start-metric.solb");
  scale_to_complexity(background, 7000, metric);
  const MeshData mesh = read_mesh(folder / "coarse.meshb");
  const AdaptResult result = adapt(mesh, {&background, &metric}, {});
  expect_same_domain(result.mesh, mesh);
  expect_good(result, {0.85, 0.60, 0.25, 0.94});
  EXPECT_LT(measure(result.mesh, result.log_metrics).length_max, 5);
}

}  // namespace
}  // namespace weft::meshing::adapt_test

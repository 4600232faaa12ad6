// Adaptation does not know how strongly the metric stretches: a squeezed domain with its metric squeezed
// alike is the same problem.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "meshing/adapt/adapt.h"
#include "meshing/adapt/stages.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/mesh/structured_box.h"
#include "meshing/metric/measures.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"
#include "tests/support/repetitions.h"
#include "tests/support/turning_metric.h"

namespace weft::meshing::anisotropy_test {
namespace {

/// Ends an adaptation that would run for ever, so that the test can say so.
class Watch {
 public:
  explicit Watch(std::chrono::seconds longest) : thread_([this, longest] { run(longest); }) {}
  ~Watch() {
    done_ = true;
    thread_.join();
  }
  const std::atomic<bool>* flag() const { return &flag_; }

 private:
  void run(std::chrono::seconds longest) {
    const auto end = std::chrono::steady_clock::now() + longest;
    while (!done_ && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    flag_ = true;
  }
  std::atomic<bool> flag_{false}, done_{false};
  std::thread thread_;
};

struct Outcome {
  Measures measures;
  std::uint64_t operations = 0;
};

/// Adapts the unit cube, squeezed by `ratio` along `axis`, to `size` in the space before.
Outcome adapt_squeezed(double ratio, const Vec& axis, double size, std::uint32_t cells) {
  const Vec n = (1 / norm(axis)) * axis;
  MeshData mesh = support::unit_cube(cells);
  for (Point& p : mesh.points) p = p + ((1 / ratio - 1) * dot(p, n)) * n;
  const double more = 2 * std::log(ratio);
  const LogMetric wanted = identity_tensor(-2 * std::log(size)) +
                           more * SymTensor{n.x * n.x, n.x * n.y, n.y * n.y, n.x * n.z, n.y * n.z, n.z * n.z};
  const LogMetricField field(mesh.points.size(), wanted);
  const Watch watch(std::chrono::seconds(60));
  AdaptOptions options;
  options.interrupt = watch.flag();
  const AdaptResult result = adapt(mesh, {&mesh, &field}, options);
  EXPECT_FALSE(result.report.interrupted) << "does not end";
  EXPECT_EQ(check_mesh(result.mesh).num_problems, 0u);
  Outcome outcome;
  outcome.measures = measure(result.mesh, result.log_metrics);
  for (const auto& of_operator : result.report.counts.of) outcome.operations += of_operator[0];
  return outcome;
}

class Squeezed : public testing::TestWithParam<Vec> {};

TEST_P(Squeezed, CubesAreTheSameProblemUpToAMillion) {
  const Outcome plain = adapt_squeezed(1, GetParam(), 0.1, 3);
  for (const double ratio : {1e3, 3e4, 1e5, 1e6}) {
    if (ratio < 1e6 && !support::repetitions(0, 1)) continue;
    SCOPED_TRACE(ratio);
    const Outcome squeezed = adapt_squeezed(ratio, GetParam(), 0.1, 3);
    const auto &a = plain.measures, &b = squeezed.measures;
    EXPECT_NEAR(static_cast<double>(squeezed.operations), static_cast<double>(plain.operations),
                0.1 * static_cast<double>(plain.operations));
    EXPECT_NEAR(b.quality_mean, a.quality_mean, 0.005);
    EXPECT_NEAR(b.quality_q01, a.quality_q01, 0.02);
    EXPECT_NEAR(b.edges_unit, a.edges_unit, 0.01);
    EXPECT_GT(b.quality_min, 0.4);
  }
}

INSTANTIATE_TEST_SUITE_P(Axes, Squeezed,
                         testing::Values(Vec{1, 2, 3}, Vec{0.3, -0.7, 0.2}, Vec{1, 1, 1}, Vec{0, 0, 1}));

/// Twelve tets say nothing about the directions that the metric has between their vertices: points created at
/// once are in each other's way (Q mean 0.34 where the adaptation does not start again).
TEST(TurningMetric, OfACoarseSlabIsMet) {
  const MeshData mesh = support::thin_slab();
  const LogMetricField field = support::turning_metric(mesh, 1000, 2);
  const AdaptResult result = adapt(mesh, {&mesh, &field}, {});
  EXPECT_EQ(check_mesh(result.mesh).num_problems, 0u);
  EXPECT_GT(measure(result.mesh, result.log_metrics).quality_mean, 0.45);
}

std::ptrdiff_t starts_again(const AdaptReport& report) {
  return std::ranges::count(report.stages, "start again", &StageReport::name);
}

/// Starting again would meet the same frozen faces.
TEST(TurningMetric, WhereMostTetsAreAtFrozenVerticesNothingStartsAgain) {
  BoxOptions box;
  box.cells = {6, 6, 1};
  box.max = {1, 1, 0.02};
  const MeshData mesh = structured_box(box);
  for (const bool frozen : {false, true}) {
    SCOPED_TRACE(frozen);
    support::KernelRig rig(mesh, support::turning_metric(mesh, 60, 2));
    if (frozen)
      for (const VertexId v : rig.live_vertices()) rig.mesh.freeze(v);
    AdaptReport report;
    adapt_in_place(rig.kernel, {}, Extent::everything, report);
    rig.judge_by(MetricMean::arithmetic);
    support::expect_sound(rig.mesh);
    double at_frozen = 0, poor = 0;
    const std::vector<TetId> tets = rig.live_tets();
    for (const TetId t : tets) {
      at_frozen += rig.mesh.has_frozen(t);
      poor += rig.mesh.quality(t) < kShiftBelow;
    }
    const auto all = static_cast<double>(tets.size());
    if (frozen) {
      EXPECT_GT(at_frozen, 0.5 * all);
      EXPECT_GT(poor, kMisfitShare * all);
      EXPECT_EQ(starts_again(report), 0);
    } else {
      EXPECT_GT(starts_again(report), 0);
    }
  }
}

}  // namespace
}  // namespace weft::meshing::anisotropy_test

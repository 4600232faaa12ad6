// The driver: the order of operations of the paper's requirement 6 over work lists.
#include "meshing/adapt.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>

#include "meshing/import_mesh.h"
#include "meshing/passes.h"
#include "meshing/renumber.h"

namespace weft::meshing {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// One adaptation from the first mark to the last improvement.
class Adaptation {
 public:
  Adaptation(Kernel& kernel, const AdaptOptions& options, AdaptReport& report)
      : kernel_(kernel), mesh_(kernel.mesh), crew_(kernel, std::max(1, options.threads), options.interrupt),
        options_(options), report_(report) {}

  void run() {
    mark_everything();
    stage("collapse", [&] { repeat(5, 0.01, [&] { return collapse_pass(crew_); }); });
    stage("create points", [&] { create_points(); });
    stage("reconnect and smooth", [&] { optimise(); });
    stage("improve", [&] { improve_quality(); });
    crew_.run([&] { renumber(); });
    report_.interrupted = crew_.interrupted();
  }

 private:
  template <class F>
  void stage(const char* name, F f) {
    if (crew_.interrupted()) return;
    const auto start = Clock::now();
    f();
    StageReport s;
    s.name = name;
    s.seconds = seconds_since(start);
    s.counts = crew_.take_counts();
    report_.counts += s.counts;
    report_.stages.push_back(s);
    if (getenv("WEFT_DEBUG")) fprintf(stderr, "%-24s %.2f s\n", name, s.seconds);
  }

  template <class F>
  std::uint64_t pass(const char* name, F f) {
    const auto start = Clock::now();
    const std::uint64_t n = f();
    if (getenv("WEFT_DEBUG")) fprintf(stderr, "  %-12s %9lu  %.2f s  slots %u\n", name, n, seconds_since(start), mesh_.tet_slots());
    return n;
  }

  template <class F>
  void repeat(int most, double share, F f) {
    std::uint64_t first = 0;
    for (int i = 0; i < most && !crew_.interrupted(); ++i) {
      const std::uint64_t n = pass("repeat", f);
      if (i == 0) first = n;
      if (n == 0 || static_cast<double>(n) < share * static_cast<double>(first)) return;
    }
  }

  void create_points() {
    std::uint32_t renumbered_at = mesh_.tet_slots();
    const double root2 = kernel_.limits.long_edge;
    for (int i = 0; i < 40 && !crew_.interrupted(); ++i) {
      const std::uint64_t n = pass("split", [&] { return split_pass(crew_, root2); });
      if (n * 1000 < mesh_.tet_slots()) break;
      pass("swap", [&] { return swap_pass(crew_, 0.5); });
      if (mesh_.tet_slots() > 2 * renumbered_at) {
        crew_.run([&] { renumber(); });
        renumbered_at = mesh_.tet_slots();
      }
    }
  }

  void optimise() {
    for (int i = 0; i < 4 && !crew_.interrupted(); ++i) {
      pass("swap", [&] { return swap_pass(crew_, 0.9); });
      pass("smooth", [&] { return smooth_pass(crew_); });
      pass("collapse", [&] { return collapse_pass(crew_); });
      pass("split", [&] { return split_pass(crew_, kernel_.limits.long_edge); });
    }
    for (int i = 0; i < 3 && !crew_.interrupted(); ++i) {
      pass("swap", [&] { return swap_pass(crew_, 0.95); });
      pass("smooth", [&] { return smooth_pass(crew_); });
    }
  }

  void improve_quality() {
    for (int i = 0; i < 5 && !crew_.interrupted(); ++i)
      if (pass("improve", [&] { return improve_pass(crew_, 0.4); }) == 0) break;
  }

  void renumber() {
    renumber_along_curve(mesh_);
    crew_.forget_free_slots();
  }

  void mark_everything() {
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) mesh_.mark(TetId(i), kAllTetMarks);
    for (std::uint32_t i = 0; i < mesh_.vertex_slots(); ++i)
      if (mesh_.alive(VertexId(i))) mesh_.set_smooth_mark(VertexId(i), true);
  }

  Kernel& kernel_;
  TetMesh& mesh_;
  Crew crew_;
  const AdaptOptions& options_;
  AdaptReport& report_;
};

double bounding_box_diagonal(const MeshData& m) {
  Point lo = m.points[0], hi = m.points[0];
  for (const Point& p : m.points)
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], p[k]);
      hi[k] = std::max(hi[k], p[k]);
    }
  return norm(hi - lo);
}

}  // namespace

AdaptResult adapt(const MeshData& input, const BackgroundData& background_data, const AdaptOptions& options) {
  const auto start = Clock::now();
  AdaptResult result;
  ImportedMesh imported = import_mesh(input, options.ridge_angle_degrees, std::size_t{1} << 28, std::size_t{1} << 30);
  result.report.warnings = std::move(imported.warnings);
  const Background background(*background_data.mesh, *background_data.log_metrics);
  read_metric(*imported.mesh, background, background_data.mesh == &input);
  Kernel kernel{*imported.mesh, background, *imported.surface, {}};
  kernel.limits.hausd = options.hausd > 0 ? options.hausd : 0.01 * bounding_box_diagonal(input);
  if (getenv("WEFT_DEBUG")) fprintf(stderr, "import %.2f s\n", seconds_since(start));
  Adaptation(kernel, options, result.report).run();
  export_mesh(*imported.mesh, *imported.surface, imported.patch_required, result.mesh, result.log_metrics);
  result.report.seconds = seconds_since(start);
  return result;
}

}  // namespace weft::meshing

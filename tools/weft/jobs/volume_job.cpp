// Checks, grid, filling, measures and output, each timed.
#include "tools/weft/jobs/volume_job.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <chrono>

#include "meshing/io/mesh_file.h"
#include "meshing/metric/measures.h"
#include "tools/weft/jobs/named_error.h"
#include "tools/weft/jobs/outputs.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/report/summary.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/interrupt.h"
#include "tools/weft/terminal/text.h"

namespace weft::tools {
namespace {

using meshing::MeshData;

class VolumeJob {
 public:
  VolumeJob(const std::string& name, const MeshData& surface, const meshing::RefNames& names,
            const VolumeRequest& request)
      : name_(name),
        surface_(surface),
        names_(names),
        request_(request),
        progress_(request.verbosity.style()) {}

  int run() {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(request_.fill.adapt.threads));
    check_writable(request_.output);
    check_writable(output_paths(request_.output).solution);
    make_grid();
    fill();
    progress_.update("writing", 1, result_.mesh.tets.size());
    write();
    progress_.finish();
    print_summary();
    return result_.report.interrupted ? kGoalNotMet : kDone;
  }

 private:
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  void make_grid() {
    progress_.update("checking the surface", 0, 0);
    naming(name_, [&] {
      const meshing::ClosedSurface closed = meshing::close_surface(surface_, request_.checks);
      warnings_ = closed.warnings;
      progress_.update("initial grid", 0, 0);
      grid_ = meshing::make_initial_grid(closed, request_.grid);
    });
    grid_seconds_ = now() - start_;
    if (grid_.left_on_surface > 0)
      warnings_.push_back(fmt::format("{} points had to be added on the surface", grid_.left_on_surface));
    if (grid_.turned > 0)
      warnings_.push_back(fmt::format("{} triangles that looked inwards turned", grid_.turned));
  }

  void fill() {
    meshing::FillOptions options = request_.fill;
    options.adapt.interrupt = interrupt_.flag();
    options.adapt.progress = [this](const std::string& stage, double done, std::uint64_t tets) {
      progress_.update(stage, done, tets);
    };
    MeshData background;
    meshing::LogMetricField sizes;
    if (!request_.metric.empty()) {
      background = meshing::read_mesh(request_.background);
      sizes = meshing::metric_from_solution(meshing::read_solution(request_.metric), background.points.size(),
                                            request_.metric);
      options.background = {&background, &sizes};
    }
    result_ = naming(name_, [&] { return meshing::fill_volume(grid_.mesh, options); });
    warnings_.insert(warnings_.end(), result_.report.warnings.begin(), result_.report.warnings.end());
    fill_seconds_ = now() - start_ - grid_seconds_;
  }

  void write() {
    write_mesh_with_solution(output_paths(request_.output), result_.mesh,
                             meshing::solution_from_metric(result_.log_metrics), {}, names_);
  }

  void print_summary() const {
    const MeshData& mesh = result_.mesh;
    const Verbosity& verbosity = request_.verbosity;
    for (const std::string& w : warnings_) verbosity.print("note: {}\n", w);
    verbosity.print("{}: {} vertices, {} tets, {} triangles, {} region{}\n", request_.output,
                    grouped(std::uint64_t{mesh.points.size()}), grouped(std::uint64_t{mesh.tets.size()}),
                    grouped(std::uint64_t{mesh.triangles.size()}), grid_.regions,
                    grid_.regions == 1 ? "" : "s");
    verbosity.print("{}\n", shape_text(meshing::measure_shape(mesh)));
    verbosity.print("surface and initial grid {}, filling {}\n", seconds_text(grid_seconds_),
                    seconds_text(fill_seconds_));
  }

  const std::string& name_;
  const MeshData& surface_;
  const meshing::RefNames& names_;
  const VolumeRequest& request_;
  InterruptGuard interrupt_;
  Progress progress_;
  meshing::InitialGrid grid_;
  meshing::AdaptResult result_;
  std::vector<std::string> warnings_;
  double start_ = now(), grid_seconds_ = 0, fill_seconds_ = 0;
};

}  // namespace

void add_volume_output(CLI::App& command, VolumeRequest& request) {
  command.add_option("-o,-x,--out", request.output, "the mesh (also -out)")
      ->type_name("FILE")
      ->check(volume_output_name());
  add_threads(command, request.fill.adapt.threads);
  add_verbosity(command, request.verbosity);
}

int make_volume(const std::string& name, const MeshData& surface, const meshing::RefNames& names,
                const VolumeRequest& request) {
  return VolumeJob(name, surface, names, request).run();
}

}  // namespace weft::tools

// Initial meshes: checks of the surface, grid, filling.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "meshing/fields/coverage.h"
#include "meshing/initial/closed_surface.h"
#include "meshing/initial/fill_volume.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/initial_grid.h"
#include "meshing/initial/repair_surface.h"
#include "tools/common/naming.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/monitor.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/result_check.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/jobs/sources/repaired_input.h"
#include "weft/weft.h"

namespace weft {
namespace {

class Filling {
 public:
  Filling(const Mesh& surface, const FillOptions& options)
      : surface_(surface), options_(options), monitor_(options.run) {}

  FillResult run() {
    try {
      make_grid();
    } catch (const meshing::Interrupted&) {
      throw RunError(tools::text_of(monitor_.reason()) + " before there was a mesh");
    }
    fill();
    return std::move(result_);
  }

 private:
  void make_grid() {
    monitor_.update("checking the surface", 0, 0);
    const meshing::ClosedSurface closed =
        options_.run.repair ? close_mended() : meshing::close_surface(surface_, {options_.merge});
    result_.warnings = closed.warnings;
    monitor_.update("initial grid", 0, 0);
    meshing::check_interrupt(&monitor_.flag());
    if (options_.remesh_surface) model_ = tools::model_of(options_.geometry, surface_, "surface");
    for (std::string& warning : tools::model_warnings(model_.get()))
      result_.warnings.push_back(std::move(warning));
    meshing::GridOptions options{options_.materials, {}, &monitor_.flag()};
    if (has_bodies() && !options_.materials)
      options.bodies_at = [this](auto points) { return model_->bodies_at(points); };
    grid_ = meshing::make_initial_grid(closed, options);
    result_.regions = grid_.regions;
    result_.grid_seconds = watch_.lap();
    if (has_bodies() && grid_.regions != model_->geometry().num_bodies())
      result_.warnings.push_back(fmt::format("{} volumes have been filled where the model has {} bodies",
                                             grid_.regions, model_->geometry().num_bodies()));
    if (has_bodies() && grid_.voids > 0)
      result_.warnings.push_back(
          fmt::format("enclosed volumes that belong to no body of the model, left empty: {}", grid_.voids));
    if (grid_.left_on_surface > 0)
      result_.warnings.push_back(
          fmt::format("{} points had to be added on the surface", grid_.left_on_surface));
    if (grid_.turned > 0)
      result_.warnings.push_back(fmt::format("{} triangles that looked inwards turned", grid_.turned));
  }

  /// What several bodies of a model enclose may be another's place, not a hole.
  bool has_bodies() const { return model_ && model_->geometry().num_bodies() > 1; }

  meshing::ClosedSurface close_mended() {
    Mesh mended = surface_;
    std::string left;
    meshing::SurfaceChecks checks{options_.merge};
    result_.mends = tools::mends_of(meshing::repair_surface(mended, &left, &monitor_.flag(), &checks.source));
    for (const Mend& m : result_.mends)
      if (m.unit == "distance") result_.deviation = std::max(result_.deviation, m.amount);
    try {
      return meshing::close_surface(mended, checks);
    } catch (const InputError& error) {
      if (left.empty()) throw;
      throw InputError("", "", fmt::format("{}; not mended: {}", error.what(), left));
    }
  }

  void fill() {
    meshing::FillOptions options;
    options.growth = options_.growth;
    options.size = options_.size;
    options.remesh_surface = options_.remesh_surface;
    if (options_.metric) {
      options.background = {options_.background, &options_.metric->logarithms()};
      tools::warn_of_uncovered(
          tools::naming("background", [&] { return meshing::uncovered(*options_.background, grid_.mesh); }),
          grid_.mesh.points.size(), result_.warnings);
    }
    options.adapt.threads = tools::number_of_threads(options_.run.threads);
    options.adapt.ridge_angle_degrees = options_.geometry.ridge_angle;
    options.adapt.hausd = options_.geometry.hausd;
    options.adapt.model = model_;
    options.adapt.interrupt = &monitor_.flag();
    options.adapt.out_of_memory = [this] { monitor_.out_of_memory(); };
    options.adapt.progress = [this](const std::string& stage, double done, std::uint64_t tets) {
      monitor_.update(stage, done, tets);
    };
    meshing::AdaptResult filled = meshing::fill_volume(grid_.mesh, options);
    result_.mesh = std::move(filled.mesh);
    result_.metric = Metric::from_logarithms(std::move(filled.log_metrics));
    result_.cancelled = filled.report.interrupted;
    if (result_.cancelled) result_.ended_by = tools::text_of(monitor_.reason());
    if (options_.run.verify) {
      monitor_.update("checking the result", 0.99, result_.mesh.tets.size());
      tools::check_conforms(result_.mesh);
    }
    if (const auto& model = filled.report.model) {
      tools::warn_of_faults(*model, result_.warnings);
      result_.missed = tools::worse_on_model(*model);
    }
    result_.warnings.insert(result_.warnings.end(), filled.report.warnings.begin(),
                            filled.report.warnings.end());
    result_.fill_seconds = watch_.lap();
  }

  const Mesh& surface_;
  const FillOptions& options_;
  tools::Monitor monitor_;
  tools::Stopwatch watch_;
  std::shared_ptr<const meshing::Model> model_;
  meshing::InitialGrid grid_;
  FillResult result_;
};

}  // namespace

FillResult fill(const Mesh& surface, const FillOptions& options) {
  Options common;
  common.geometry = options.geometry;
  common.run = options.run;
  validate(common);
  if ((options.background == nullptr) != (options.metric == nullptr))
    throw OptionError("--background", "requires --metric and the reverse");
  const WholeMesh whole(surface, meshing::CollapsedTriangles::allowed);  // they are left out
  if (options.metric) check_length(*options.background, options.metric->size(), "metric");
  return tools::with_threads(tools::number_of_threads(options.run.threads),
                             [&] { return Filling(*whole, options).run(); });
}

}  // namespace weft

// Reads sizes, fills, writes, tells.
#include "tools/weft/jobs/volume_job.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "tools/common/inputs.h"
#include "tools/common/measures_text.h"
#include "tools/common/naming.h"
#include "tools/common/text.h"
#include "tools/weft/options/limit_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/interrupt.h"

namespace weft::tools {
namespace {

void print_summary(const VolumeRequest& request, const FillResult& result) {
  const Verbosity& verbosity = request.verbosity;
  const Mesh& mesh = result.mesh;
  verbosity.print("{}", mends_text(result.mends));
  for (const std::string& w : result.warnings) verbosity.print("note: {}\n", w);
  for (const std::string& reason : result.missed) verbosity.print("GOAL NOT MET: {}\n", reason);
  if (result.cancelled) verbosity.print("ended early: {}\n", result.ended_by);
  verbosity.print("{}: {}, {}, {}, {}\n", request.output, counted(mesh.points.size(), "vertex"),
                  counted(mesh.tets.size(), "tet"), counted(mesh.triangles.size(), "triangle"),
                  counted(result.regions, "region"));
  verbosity.print("{}\n", shape_text(measure_shape(mesh)));
  verbosity.print("surface and initial grid {}, filling {}\n", seconds_text(result.grid_seconds),
                  seconds_text(result.fill_seconds));
}

}  // namespace

void add_volume_output(CLI::App& command, VolumeRequest& request) {
  command.add_option("-o,-x,--out", request.output, "the mesh (also -out)")
      ->type_name("FILE")
      ->check(volume_output_name());
  add_threads(command, request.fill.run.threads);
  add_limits(command, request.fill.run);
  add_verbosity(command, request.verbosity);
}

int make_volume(const std::string& name, const Mesh& surface, const RefNames& names,
                const VolumeRequest& request) {
  const ResultFiles files = result_files(request.output);
  for (const std::string& file : {files.mesh, files.metric})
    keep_inputs(file, file, {request.surface, request.background, request.metric});
  check_writable(files.mesh);
  check_writable(files.metric);
  Progress progress(request.verbosity.style());
  const InterruptGuard interrupt;
  FillOptions options = request.fill;
  options.run.cancel = interrupt.flag();
  options.run.progress = [&progress](const weft::Progress& now) {
    progress.show(now);
    return true;
  };
  Mesh background;
  Metric sizes;
  if (!request.metric.empty()) {
    background = read_mesh(request.background);
    sizes = read_metric(request.metric, background);
    options.background = &background;
    options.metric = &sizes;
  }
  const FillResult result = naming(name, [&] { return fill(surface, options); });
  progress.update("writing", 1, result.mesh.tets.size());
  write_result(request.output, result.mesh, result.metric, {}, names);
  progress.finish();
  print_summary(request, result);
  return result.cancelled || !result.missed.empty() ? kGoalNotMet : kDone;
}

}  // namespace weft::tools

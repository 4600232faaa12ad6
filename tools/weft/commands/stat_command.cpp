// `weft stat`: the measures of a mesh, in a metric or by itself.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "tools/common/measures_text.h"
#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/metric_options.h"
#include "tools/weft/options/model_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/on_ranks.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kStatFooter = R"(Examples:
  weft stat wing.meshb --metric wing.solb --histogram
  weft stat wing.meshb --metric wing.solb --plot wing.pdf
  weft stat wing.meshb --geometry wing.step

Without a metric: counts, shapes of the tets, bounding box, volumes and areas by reference. With one:
mean ratios of the tets and lengths of the edges in the metric, as `weft adapt` reports them.
--quiet prints nothing; the exit code is 0 if everything could be read.)";

struct StatCommand {
  std::string mesh;
  MetricOptions metric;
  GeometryOptions geometry;
  std::string plot;
  bool json = false, histogram = false;
  Verbosity verbosity;
};

std::string by_ref_text(const char* what, const std::map<std::int32_t, double>& by_ref) {
  std::string text;
  double total = 0;
  for (const auto& [ref, value] : by_ref) {
    text += fmt::format("  {} of reference {:<10}{:>16.9g}\n", what, ref, value);
    total += value;
  }
  if (by_ref.size() > 1) text += fmt::format("  {} in all{:<14}{:>16.9g}\n", what, "", total);
  return text;
}

std::string geometry_text(const MeshFigures& figures) {
  const MeshCounts& counts = figures.counts;
  const Geometry& g = figures.geometry;
  std::string text;
  const auto line = [&](const char* name, std::uint64_t n) {
    if (n > 0) text += fmt::format("  {:<20}{:>14}\n", name, grouped(n));
  };
  line("vertices", counts.vertices);
  line("tets", counts.tets);
  line("triangles", counts.triangles);
  line("edges", counts.edges);
  line("corners", figures.corners);
  line("ridges", figures.ridges);
  line("required vertices", figures.required_vertices);
  line("required edges", figures.required_edges);
  line("required triangles", figures.required_triangles);
  if (counts.tets > 0) text += fmt::format("  {}\n", shape_text(g.shape));
  text += fmt::format("  box from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})\n", g.min.x, g.min.y,
                      g.min.z, g.max.x, g.max.y, g.max.z);
  return text + by_ref_text("volume", g.volume_by_ref) + by_ref_text("area  ", g.area_by_ref);
}

std::string histograms_text(const Measures& measures) {
  return histogram_text("quality of the tets (mean ratio)", measures.quality) + "\n" +
         histogram_text("length of the edges in the metric, logarithmic", measures.length_log);
}

std::string plot_title(const StatCommand& command) {
  const auto file = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  const std::string metric =
      command.metric.file.empty() ? command.metric.function : file(command.metric.file);
  return fmt::format("{} in the metric {}", file(command.mesh), metric);
}

void plot(const StatCommand& command, const Measures& measures) {
  if (measures.num_tets == 0) throw InputError(command.mesh, "", "contains no tets to plot");
  draw_histograms(command.plot, measures, plot_title(command));
}

/// The table of measures, with histograms and a plot where they are asked for.
std::string measures_text(const StatCommand& command, const Measures& measures) {
  std::string text = measures_table({{"", &measures}});
  if (command.histogram) text += "\n" + histograms_text(measures);
  if (!command.plot.empty()) plot(command, measures);
  return text;
}

/// Draws and prints what is asked for.
void tell(const StatCommand& command, const MeshFigures& figures) {
  for (const std::string& warning : figures.model_warnings)
    if (!command.verbosity.quiet) fmt::print(stderr, "warning: {}\n", warning);
  std::string text = figures.measures ? measures_text(command, *figures.measures) : geometry_text(figures);
  if (figures.model) text += "\n" + summary(*figures.model);
  command.verbosity.print("{}", command.json ? to_json(figures) + "\n" : text);
}

int run_on_ranks(const StatCommand& command) {
  const MeasuresOnRanks done = measure_on_ranks(command.mesh, command.metric);
  if (!done.first) return kDone;
  for (const std::string& warning : done.warnings)
    if (!command.verbosity.quiet) fmt::print(stderr, "warning: {}\n", warning);
  tell(command, done);
  return kDone;
}

int run_stat(const StatCommand& command) {
  if (command.histogram && !command.metric.given())
    throw CLI::RequiresError("--histogram", "--metric or --metric-fn");
  if (!command.plot.empty() && !command.metric.given())
    throw CLI::RequiresError("--plot", "--metric or --metric-fn");
  const PlaceOnRanks place = place_on_ranks();
  if (!command.plot.empty() && place.rank == 0) check_writable(command.plot);
  if (under_mpirun() && command.geometry.model.empty()) return run_on_ranks(command);
  if (place.rank != 0) return kDone;
  if (place.ranks > 1 && !command.verbosity.quiet) fmt::print(stderr, "{}", done_by_first("stat --geometry"));
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  const Mesh mesh = read_mesh(command.mesh);
  progress.phase("measuring");
  Metric metric;
  if (command.metric.given())
    metric = make_metric(mesh, command.metric, command.geometry, command.mesh).metric;
  const MeshFigures figures =
      measure_all(mesh, command.metric.given() ? &metric : nullptr, command.geometry, command.mesh);
  progress.finish();
  tell(command, figures);
  return kDone;
}

}  // namespace

void add_stat_command(CLI::App& app, Action& action) {
  CLI::App* sub =
      app.add_subcommand("stat", "measure a mesh: counts, volumes, quality and lengths in a metric");
  sub->footer(kStatFooter);
  auto command = std::make_shared<StatCommand>();
  sub->add_option("MESH", command->mesh, "the mesh")->type_name("FILE")->required();
  add_metric_source(*sub, command->metric);
  add_model(*sub, command->geometry);
  sub->add_flag("--json", command->json, "print everything as JSON, including histograms");
  sub->add_flag("--histogram", command->histogram, "also print histograms of quality and edge length");
  sub->add_option("--plot", command->plot, "draw the histograms: .png, .svg or .pdf")
      ->type_name("FILE")
      ->check(picture_name());
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_stat(*command); }; });
}

}  // namespace weft::tools

// `weft stat`: the measures of a mesh, in a metric or by itself.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/common/measures_text.h"
#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/metric_options.h"
#include "tools/weft/options/model_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFooter = R"(Examples:
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

Json json_of(const std::map<std::int32_t, double>& by_ref) {
  Json all = Json::object();
  for (const auto& [ref, value] : by_ref) all[std::to_string(ref)] = value;
  return all;
}

Json json_of(const Mesh& mesh, const Geometry& g) {
  return {{"schema", "weft-stat-1"},
          {"version", version()},
          {"vertices", mesh.points.size()},
          {"tets", mesh.tets.size()},
          {"triangles", mesh.triangles.size()},
          {"edges", mesh.edges.size()},
          {"corners", mesh.corners.size()},
          {"ridges", mesh.ridges.size()},
          {"required",
           {{"vertices", mesh.required_points.size()},
            {"edges", mesh.required_edges.size()},
            {"triangles", mesh.required_triangles.size()}}},
          {"shape",
           {{"quality",
             {{"mean", g.shape.quality_mean},
              {"min", g.shape.quality_min},
              {"quantile_0.01", g.shape.quality_q01}}},
            {"least_dihedral_degrees", g.shape.least_dihedral_degrees}}},
          {"bounding_box", {{g.min.x, g.min.y, g.min.z}, {g.max.x, g.max.y, g.max.z}}},
          {"volume_by_ref", json_of(g.volume_by_ref)},
          {"area_by_ref", json_of(g.area_by_ref)}};
}

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

std::string geometry_text(const Mesh& mesh, const Geometry& g) {
  std::string text;
  const auto line = [&](const char* name, std::size_t n) {
    if (n > 0) text += fmt::format("  {:<20}{:>14}\n", name, grouped(std::uint64_t{n}));
  };
  line("vertices", mesh.points.size());
  line("tets", mesh.tets.size());
  line("triangles", mesh.triangles.size());
  line("edges", mesh.edges.size());
  line("corners", mesh.corners.size());
  line("ridges", mesh.ridges.size());
  line("required vertices", mesh.required_points.size());
  line("required edges", mesh.required_edges.size());
  line("required triangles", mesh.required_triangles.size());
  if (!mesh.tets.empty()) text += fmt::format("  {}\n", shape_text(g.shape));
  text += fmt::format("  box from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})\n", g.min.x, g.min.y,
                      g.min.z, g.max.x, g.max.y, g.max.z);
  return text + by_ref_text("volume", g.volume_by_ref) + by_ref_text("area  ", g.area_by_ref);
}

std::string histograms_text(const Measures& measures) {
  return histogram_text("quality of the tets (mean ratio)", measures.quality) + "\n" +
         histogram_text("length of the edges in the metric, logarithmic", measures.length_log);
}

HistogramText plot_text(const StatCommand& command, const Measures& m) {
  const auto file = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  const std::string metric =
      command.metric.file.empty() ? command.metric.function : file(command.metric.file);
  return {fmt::format("{} in the metric {}", file(command.mesh), metric),
          fmt::format("{} tets: mean quality {:.3f}, worst 1 % below {:.3f}, least {:.3g}",
                      grouped(m.num_tets), m.quality_mean, m.quality_q01, m.quality_min),
          fmt::format("{} edges: {} unit (shaded), {} shorter, {} longer; from {:.3g} to {:.3g}",
                      grouped(m.num_edges), percent(m.edges_unit), percent(m.edges_short, 2),
                      percent(m.edges_long, 2), m.length_min, m.length_max)};
}

void plot(const StatCommand& command, const Measures& measures) {
  if (measures.num_tets == 0) throw InputError(command.mesh, "", "contains no tets to plot");
  draw_histograms(command.plot, measures, plot_text(command, measures));
}

int run_stat(const StatCommand& command) {
  if (command.histogram && !command.metric.given())
    throw CLI::RequiresError("--histogram", "--metric or --metric-fn");
  if (!command.plot.empty() && !command.metric.given())
    throw CLI::RequiresError("--plot", "--metric or --metric-fn");
  if (!command.plot.empty()) check_writable(command.plot);
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  const Mesh mesh = read_mesh(command.mesh);
  progress.phase("measuring");
  const Geometry geometry = measure_geometry(mesh);
  Json json = json_of(mesh, geometry);
  std::string text = geometry_text(mesh, geometry);
  if (command.metric.given()) {
    const Measures measures =
        measure(mesh, make_metric(mesh, command.metric, command.geometry, command.mesh).metric);
    json["measures"] = Json::parse(to_json(measures));
    text = measures_table({{"", &measures}});
    if (command.histogram) text += "\n" + histograms_text(measures);
    if (!command.plot.empty()) plot(command, measures);
  }
  if (!command.geometry.model.empty()) {
    const ModelAccount account = measure_on_model(mesh, command.geometry, command.mesh);
    json["model"] = Json::parse(to_json(account));
    text += "\n" + summary(account);
  }
  progress.finish();
  command.verbosity.print("{}", command.json ? json.dump(1) + "\n" : text);
  return kDone;
}

}  // namespace

void add_stat_command(CLI::App& app, Action& action) {
  CLI::App* sub =
      app.add_subcommand("stat", "measure a mesh: counts, volumes, quality and lengths in a metric");
  sub->footer(kFooter);
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

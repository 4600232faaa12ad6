// `weft view`: a picture of a mesh, drawn without a screen.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>

#include "tools/common/naming.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/metric_options.h"
#include "tools/weft/options/model_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kViewFooter = R"(Examples:
  weft view wing.meshb -o wing.png
  weft view fine.meshb --metric fine.solb --clip y=0.5 --from -y --color-by quality -o cut.png
  weft view fine.meshb --metric fine.solb --color-by nonconforming --size 2400x1800 -o left.pdf
  weft view wing.meshb --only 1,2,3 --clip y=0 --from iso -o wing.svg
  weft view wing.meshb --geometry wing.step --color-by deviation -o fit.png
  weft view flow.vtu --color-by field:mach --clip z=0.1 --slice --from z -o mach.png

Shows the surface. --clip removes what lies on the viewer's side of a plane like x=0.5, or on the side of P
to which the normal N points, and shows whole tets, or with --slice a plane section. Azimuths are measured
from x towards y, elevations from there towards z, in degrees. --color-by takes
  none           the surface in one colour, cut tets in another (default)
  ref            references of the triangles
  subdomain      references of the tets; of a .pvtu, its pieces (subdomains)
  quality        mean ratio of the tets, in the metric where one is given
  length         length of the edges in the metric: each colours the adjacent third of a face
  nonconforming  in red the tets with an edge outside [1/√2, √2] in the metric
  deviation      distance of the triangles' centroids from the CAD model of --geometry
  field[:NAME]   a scalar of --field or of MESH, or the length of a vector
The picture is a .png, or a .pdf or .svg with vector text around an image. Edges closer than a pixel fade.)";

struct ViewCommand {
  std::string mesh, output;
  MetricOptions metric;
  GeometryOptions geometry;
  std::vector<std::string> fields;
  std::string color_by = "none";
  bool no_edges = false, no_legend = false, no_axes = false;
  PictureOptions picture;
  Verbosity verbosity;
};

constexpr const char* kDeviation = "deviation";  // is drawn as a field

/// The word before the colon, if there is one.
std::string kind_of(const std::string& color_by) {
  return color_by.starts_with("field:") || color_by == kDeviation ? "field" : color_by;
}

std::string check_colouring(const std::string& word) {
  PictureOptions picture;
  picture.color_by = kind_of(word);
  try {
    check_picture(picture);
    return {};
  } catch (const OptionError& error) {
    return error.reason();
  }
}

void check_needs(const ViewCommand& command) {
  const std::string& by = command.picture.color_by;
  if ((by == "length" || by == "nonconforming") && !command.metric.given())
    throw CLI::RequiresError("--color-by " + command.color_by, "--metric or --metric-fn");
  const bool deviation = command.color_by == kDeviation;
  if (deviation == command.geometry.model.empty())
    throw deviation ? CLI::RequiresError("--color-by deviation", "--geometry")
                    : CLI::RequiresError("--geometry", "--color-by deviation");
  if (deviation && command.fields.empty()) return;
  if (by == "field" && command.fields.empty() && !holds_fields(command.mesh))
    throw CLI::RequiresError("--color-by " + command.color_by, "--field");
  if ((by != "field" || deviation) && !command.fields.empty())
    throw CLI::ValidationError("--field", "is for --color-by field");
}

std::vector<double> scalars_of(const Field& field) {
  if (field.kind == Field::Kind::scalar) return field.values;
  std::vector<double> lengths(field.values.size() / 3);
  for (std::size_t v = 0; v < lengths.size(); ++v)
    lengths[v] = std::hypot(field.values[3 * v], field.values[3 * v + 1], field.values[3 * v + 2]);
  return lengths;
}

/// The values to colour by, and their name: of the field called for, or of the first that is no tensor.
std::pair<std::vector<double>, std::string> colour_field(const ViewCommand& command, std::size_t num_points) {
  const std::vector<std::string> files =
      command.fields.empty() ? std::vector<std::string>{command.mesh} : command.fields;
  const bool named = command.color_by != "field";
  const std::string wanted = named ? command.color_by.substr(6) : "";
  std::string known;
  for (Field& field : read_fields(files, num_points, command.mesh).fields) {
    known += (known.empty() ? "" : ", ") + field.name;
    if (field.kind == Field::Kind::tensor || (!wanted.empty() && field.name != wanted)) continue;
    const std::string name = field.kind == Field::Kind::vector ? "|" + field.name + "|" : field.name;
    return {scalars_of(field), name};
  }
  throw InputError(files.front(), "",
                   fmt::format("has no scalar or vector field{}, but {}",
                               wanted.empty() ? "" : " '" + wanted + "'", known));
}

/// The same: how far triangles are from the CAD model.
std::pair<std::vector<double>, std::string> deviation_field(const ViewCommand& command, const Mesh& mesh) {
  std::vector<double> deviations;
  measure_on_model(mesh, command.geometry, command.mesh, 0, &deviations);
  return {std::move(deviations), kDeviation};
}

/// What a run in subdomains writes into one file does not tell them any more; pieces do.
Mesh mesh_to_show(const ViewCommand& command, RefNames& names) {
  const bool pieces = std::filesystem::path(command.mesh).extension() == ".pvtu";
  if (pieces && command.picture.color_by == "subdomain") return read_mesh_by_piece(command.mesh);
  return read_mesh(command.mesh, &names);
}

int run_view(ViewCommand& command) {
  PictureOptions& picture = command.picture;
  picture.color_by = kind_of(command.color_by);
  picture.edges = !command.no_edges;
  picture.legend = !command.no_legend;
  picture.axes = !command.no_axes;
  check_needs(command);
  const PictureSize size = check_picture(picture);
  check_writable(command.output);
  RefNames names;
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  const Mesh mesh = mesh_to_show(command, names);
  Metric metric;
  if (command.metric.given()) metric = make_metric(mesh, command.metric, command.mesh).metric;
  std::pair<std::vector<double>, std::string> field;
  if (command.color_by == kDeviation)
    field = deviation_field(command, mesh);
  else if (picture.color_by == "field")
    field = colour_field(command, mesh.points.size());
  const PictureSource source{mesh, command.metric.given() ? &metric : nullptr, field.first, field.second,
                             &names};
  progress.phase("drawing");
  naming(command.mesh, [&] { draw(command.output, source, picture); });
  progress.finish();
  command.verbosity.print("{}: {} x {} pixels\n", command.output, size.width, size.height);
  return kDone;
}

void add_camera_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Camera";
  sub.add_option("--from", command.picture.from,
                 "viewpoint: x, -x, y, -y, z, -z, iso (default), AZIMUTH,ELEVATION")
      ->type_name("VIEW")
      ->group(kGroup);
  sub.add_option("--up", command.picture.up,
                 "direction that points up in the picture, named likewise; default z")
      ->type_name("VIEW")
      ->group(kGroup);
  auto* zoom = sub.add_option("--zoom", command.picture.zoom, "magnification; default 1")
                   ->type_name("F")
                   ->check(positive_number())
                   ->group(kGroup);
  sub.add_option("--focus", command.picture.focus, "fill the picture with this box: X0,Y0,Z0,X1,Y1,Z1")
      ->type_name("BOX")
      ->excludes(zoom)
      ->group(kGroup);
}

void add_cut_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Cut";
  auto* clip = sub.add_option("--clip", command.picture.clip,
                              "remove one side of x=P, y=P, z=P or PX,PY,PZ,NX,NY,NZ; see below")
                   ->type_name("PLANE")
                   ->group(kGroup);
  sub.add_flag("--flip", command.picture.flip, "remove the other side")->needs(clip)->group(kGroup);
  sub.add_flag("--slice", command.picture.slice, "a plane section instead of whole tets")
      ->needs(clip)
      ->group(kGroup);
  sub.add_option("--only", command.picture.only, "show only surface triangles of these references")
      ->type_name("REF,...")
      ->delimiter(',')
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kGroup);
}

void add_colour_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Colour";
  sub.add_option("--color-by", command.color_by,
                 "none, ref, subdomain, quality, length, nonconforming, deviation, field[:NAME]")
      ->type_name("WHAT")
      ->check(CLI::Validator(check_colouring, ""))
      ->group(kGroup);
  sub.add_option("--field", command.fields, "fields at the vertices of MESH; repeatable")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kGroup);
  sub.add_option("--range", command.picture.range, "limits of the colour bar: LO,HI")
      ->type_name("RANGE")
      ->group(kGroup);
  sub.add_flag("--dark", command.picture.dark, "dark background")->group(kGroup);
}

void add_sheet_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Layout";
  sub.add_option("--size", command.picture.size, "WIDTHxHEIGHT in pixels; default 1600x1200")
      ->type_name("SIZE")
      ->group(kGroup);
  sub.add_option("--title", command.picture.title, "title above the picture")
      ->type_name("TEXT")
      ->group(kGroup);
  sub.add_option("--line-width", command.picture.line_width, "line width of edges; default 1")
      ->type_name("W")
      ->check(positive_number())
      ->group(kGroup);
  sub.add_flag("--no-edges", command.no_edges, "faces without their edges")->group(kGroup);
  sub.add_flag("--no-legend", command.no_legend, "without the legend")->group(kGroup);
  sub.add_flag("--no-axes", command.no_axes, "without the directions of x, y and z")->group(kGroup);
}

}  // namespace

void add_view_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("view", "draw a picture of a mesh into a file");
  sub->footer(kViewFooter);
  auto command = std::make_shared<ViewCommand>();
  sub->add_option("MESH", command->mesh, "the mesh")->type_name("FILE")->required();
  sub->add_option("-o,-x,--out", command->output, "the picture: .png, .svg or .pdf (also -out)")
      ->type_name("FILE")
      ->check(picture_name())
      ->required();
  add_cut_options(*sub, *command);
  add_colour_options(*sub, *command);
  add_camera_options(*sub, *command);
  add_sheet_options(*sub, *command);
  add_metric_source(*sub, command->metric);
  add_model(*sub, command->geometry);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_view(*command); }; });
}

}  // namespace weft::tools

// `weft view`: a picture of a mesh, drawn without a screen.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/vtk/pvtu.h"
#include "tools/picture/mesh_picture.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/jobs/named_error.h"
#include "tools/weft/jobs/outputs.h"
#include "tools/weft/options/field_source.h"
#include "tools/weft/options/metric_source.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/picture_options.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"

namespace weft::tools {
namespace {

using meshing::Field;
using meshing::MeshData;
using picture::ColourBy;

constexpr const char* kFooter = R"(Examples:
  weft view wing.meshb -o wing.png
  weft view fine.meshb --metric fine.solb --clip y=0.5 --from -y --color-by quality -o cut.png
  weft view fine.meshb --metric fine.solb --color-by nonconforming --size 2400x1800 -o left.pdf
  weft view wing.meshb --only 1,2,3 --clip y=0 --from iso -o wing.svg
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
  field[:NAME]   a scalar of --field or of MESH, or the length of a vector
The picture is a .png, or a .pdf or .svg with vector text around an image. Edges closer than a pixel fade.)";

struct ViewCommand {
  std::string mesh, output;
  MetricRequest metric;
  FieldRequest fields;
  std::string colour_by = "none";
  std::string size = "1600x1200", from = "iso", up, clip, focus, range;
  bool dark = false, flip = false, no_edges = false, no_legend = false, no_axes = false;
  std::vector<std::int32_t> only;
  picture::PictureOptions picture;
  Verbosity verbosity;
};

const std::map<std::string, ColourBy>& colourings() {
  static const std::map<std::string, ColourBy> all = {
      {"none", ColourBy::none},           {"ref", ColourBy::ref},
      {"subdomain", ColourBy::subdomain}, {"quality", ColourBy::quality},
      {"length", ColourBy::length},       {"nonconforming", ColourBy::nonconforming},
      {"field", ColourBy::field}};
  return all;
}

/// The word before the colon, if there is one.
std::string kind_of(const std::string& colour_by) {
  return colour_by.starts_with("field:") ? "field" : colour_by;
}

std::string check_colouring(const std::string& word) {
  if (colourings().contains(kind_of(word))) return {};
  return "'" + word +
         "' is not one of none, ref, subdomain, quality, length, nonconforming, field and field:NAME";
}

/// Returns parse(), with what it finds wrong told as the fault of `option`.
template <class Parse>
auto parsed(const char* option, const Parse& parse) {
  try {
    return parse();
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError(option, error.what());
  }
}

picture::View view_of(const ViewCommand& command) {
  const meshing::Vec toward_eye = parsed("--from", [&] { return picture::direction_named(command.from); });
  if (command.up.empty()) return {toward_eye, picture::default_up(toward_eye)};
  const meshing::Vec up = parsed("--up", [&] { return picture::direction_named(command.up); });
  if (!(norm(cross(up, toward_eye)) > 0))
    throw CLI::ValidationError("--up", "'" + command.up + "' is parallel to the view direction --from");
  return {toward_eye, up};
}

std::pair<double, double> range_of(const std::string& text) {
  const std::vector<double> ends = numbers_in(text, 2);
  if (!(ends[0] < ends[1])) throw std::invalid_argument("'" + text + "' does not ascend");
  return {ends[0], ends[1]};
}

void check_needs(const ViewCommand& command, ColourBy by) {
  const bool by_length = by == ColourBy::length || by == ColourBy::nonconforming;
  if (by_length && !command.metric.given())
    throw CLI::RequiresError("--color-by " + command.colour_by, "--metric or --metric-fn");
  if (by == ColourBy::field && !command.fields.given() && !meshing::holds_fields(command.mesh))
    throw CLI::RequiresError("--color-by " + command.colour_by, "--field");
  if (by != ColourBy::field && command.fields.given())
    throw CLI::ValidationError("--field", "is for --color-by field");
  const bool continuous = by == ColourBy::quality || by == ColourBy::length || by == ColourBy::field;
  if (!command.range.empty() && !continuous)
    throw CLI::ValidationError("--range", "is for --color-by quality, length and field");
}

picture::PictureOptions picture_options(const ViewCommand& command, ColourBy by) {
  picture::PictureOptions options = command.picture;
  std::tie(options.width, options.height) = parsed("--size", [&] { return picture_size(command.size); });
  if (command.dark) options.theme = picture::dark_theme();
  if (command.no_edges) options.line_width = 0;
  options.legend = !command.no_legend;
  options.axes = !command.no_axes;
  options.view = view_of(command);
  if (!command.focus.empty()) options.focus = parsed("--focus", [&] { return box_in(command.focus); });
  if (!command.only.empty()) options.only = command.only;
  if (!command.range.empty()) options.range = parsed("--range", [&] { return range_of(command.range); });
  if (options.range && by == ColourBy::length && !(options.range->first > 0))
    throw CLI::ValidationError("--range", "lengths are above zero");
  if (!command.clip.empty()) {
    options.cut = parsed("--clip", [&] { return plane_in(command.clip, options.view.toward_eye); });
    if (command.flip) options.cut = {-1 * options.cut->normal, -options.cut->offset};
  }
  return options;
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
  FieldRequest request = command.fields;
  if (!request.given()) request.files = {command.mesh};
  const std::string wanted =
      kind_of(command.colour_by) == command.colour_by ? "" : command.colour_by.substr(6);
  std::string known;
  for (Field& field : read_fields(request, num_points, command.mesh).fields) {
    known += (known.empty() ? "" : ", ") + field.name;
    if (field.kind == Field::Kind::tensor || (!wanted.empty() && field.name != wanted)) continue;
    const std::string name = field.kind == Field::Kind::vector ? "|" + field.name + "|" : field.name;
    return {scalars_of(field), name};
  }
  throw meshing::InputError(request.files.front(), "",
                            fmt::format("has no scalar or vector field{}, but {}",
                                        wanted.empty() ? "" : " '" + wanted + "'", known));
}

/// What a run in subdomains writes into one file does not tell them any more; pieces do.
MeshData mesh_to_show(const ViewCommand& command, ColourBy by, meshing::RefNames& names) {
  if (by == ColourBy::subdomain && std::filesystem::path(command.mesh).extension() == ".pvtu")
    return meshing::read_pvtu_by_piece(command.mesh).mesh;
  return meshing::read_mesh(command.mesh, &names);
}

int run_view(const ViewCommand& command) {
  const ColourBy by = colourings().at(kind_of(command.colour_by));
  check_needs(command, by);
  const picture::PictureOptions options = picture_options(command, by);
  check_writable(command.output);
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  meshing::RefNames names;
  const MeshData mesh = mesh_to_show(command, by, names);
  meshing::LogMetricField metric;
  if (command.metric.given()) metric = make_metric(command.metric, mesh, command.mesh).field;
  std::vector<double> field;
  std::string field_name;
  if (by == ColourBy::field) std::tie(field, field_name) = colour_field(command, mesh.points.size());
  progress.phase("drawing");
  const picture::ColourSource source{by, mesh, metric, field, field_name};
  const std::string bytes = naming(command.mesh, [&] {
    return picture::mesh_picture(source, names, options, picture_format(command.output));
  });
  write_text(command.output, bytes);
  progress.finish();
  command.verbosity.print("{}: {} x {} pixels\n", command.output, options.width, options.height);
  return kDone;
}

void add_camera_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Camera";
  sub.add_option("--from", command.from, "viewpoint: x, -x, y, -y, z, -z, iso (default), AZIMUTH,ELEVATION")
      ->type_name("VIEW")
      ->group(kGroup);
  sub.add_option("--up", command.up, "direction that points up in the picture, named likewise; default z")
      ->type_name("VIEW")
      ->group(kGroup);
  auto* zoom = sub.add_option("--zoom", command.picture.zoom, "magnification; default 1")
                   ->type_name("F")
                   ->check(positive_number())
                   ->group(kGroup);
  sub.add_option("--focus", command.focus, "fill the picture with this box: X0,Y0,Z0,X1,Y1,Z1")
      ->type_name("BOX")
      ->excludes(zoom)
      ->group(kGroup);
}

void add_cut_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Cut";
  auto* clip = sub.add_option("--clip", command.clip,
                              "remove one side of x=P, y=P, z=P or PX,PY,PZ,NX,NY,NZ; see below")
                   ->type_name("PLANE")
                   ->group(kGroup);
  sub.add_flag("--flip", command.flip, "remove the other side")->needs(clip)->group(kGroup);
  sub.add_flag("--slice", command.picture.planar, "a plane section instead of whole tets")
      ->needs(clip)
      ->group(kGroup);
  sub.add_option("--only", command.only, "show only surface triangles of these references")
      ->type_name("REF,...")
      ->delimiter(',')
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kGroup);
}

void add_colour_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Colour";
  sub.add_option("--color-by", command.colour_by,
                 "none, ref, subdomain, quality, length, nonconforming or field[:NAME]")
      ->type_name("WHAT")
      ->check(CLI::Validator(check_colouring, ""))
      ->group(kGroup);
  sub.add_option("--field", command.fields.files, "fields at the vertices of MESH; repeatable")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kGroup);
  sub.add_option("--range", command.range, "limits of the colour bar: LO,HI")
      ->type_name("RANGE")
      ->group(kGroup);
  sub.add_flag("--dark", command.dark, "dark background")->group(kGroup);
}

void add_sheet_options(CLI::App& sub, ViewCommand& command) {
  constexpr const char* kGroup = "Layout";
  sub.add_option("--size", command.size, "WIDTHxHEIGHT in pixels; default 1600x1200")
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
  sub->footer(kFooter);
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
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_view(*command); }; });
}

}  // namespace weft::tools

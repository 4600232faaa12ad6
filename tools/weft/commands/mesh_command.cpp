// `weft mesh`: initial meshes, of a surface or of simple bodies.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/jobs/volume_job.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kMeshFooter = R"(Examples:
  weft mesh part.stl -o part.meshb
  weft mesh part.stl --size 0.05 --growth 1.2 -o part.meshb
  weft mesh part.stl --background old.meshb --metric sizes.solb -o part.meshb
  weft mesh ball --size 0.1 -o ball.meshb
  weft mesh wing.step --size 0.1 -o wing.meshb

SURFACE is any mesh file with triangles, or a CAD model (.step, .iges, .brep, .egads), which is meshed
within --hausd of it, every vertex on it. They must enclose one or several volumes; shared faces separate
materials, which get the tet references 1, 2 ... Of several bodies in a CAD model each is filled, with its
number as reference, and what lies between them is left empty (with --materials: filled).
The triangles are kept, and sizes grow from theirs into the volume, faster than --growth where the
triangles' sizes do. Repaired with a note: coincident points,
degenerate and duplicate triangles, orientations. Refused: open and self-intersecting surfaces. --repair
closes gaps and openings, and makes of surfaces that cross the boundary of the union of their volumes, if
they go around any.)";

constexpr const char* kBoxFooter = R"(Example:
  weft mesh box -o cube.meshb --cells 8
  weft mesh box -o channel.meshb --cells 40 10 10 --max 4 1 1

References of the triangles: 1 x-min, 2 x-max, 3 y-min, 4 y-max, 5 z-min, 6 z-max. The 12 edges of the
box are ridges, its 8 vertices corners.)";

struct BoxCommand {
  std::string output;
  std::vector<std::uint32_t> cells = {8};  ///< in each direction, or one number for all
  std::array<double, 3> min = {0, 0, 0}, max = {1, 1, 1};
  Verbosity verbosity;
};

int run_box(const BoxCommand& command) {
  const auto point = [](const std::array<double, 3>& x) { return Point{x[0], x[1], x[2]}; };
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!(command.min[axis] < command.max[axis]))
      throw CLI::ValidationError("--max", "must be above --min in every direction");
  const std::vector<std::uint32_t>& n = command.cells;
  if (n.size() == 2) throw CLI::ValidationError("--cells", "takes one number or three");
  check_writable(command.output);
  const Mesh mesh = box({{n.front(), n[n.size() / 2], n.back()}, point(command.min), point(command.max)});
  write_mesh(command.output, mesh);
  command.verbosity.print("{}: {}, {}\n", command.output, counted(mesh.points.size(), "vertex"),
                          counted(mesh.tets.size(), "tet"));
  return kDone;
}

/// Triangles on a CAD model, remeshed on it while the volume is filled.
int run_model(VolumeRequest volume) {
  volume.fill.geometry.model = volume.surface;
  volume.fill.remesh_surface = true;
  TessellationOptions triangles;
  triangles.sagitta = volume.fill.geometry.hausd;
  return make_volume(volume.surface, tessellate(volume.fill.geometry, triangles), {}, volume);
}

int run_surface(const VolumeRequest& volume) {
  if (volume.surface.empty())
    throw CLI::RequiredError(
        "give a surface (weft mesh part.stl -o part.meshb) or a subcommand: box, ball, "
        "cylinder, delta-wing",
        CLI::ExitCodes::RequiredError);
  if (volume.output.empty()) throw CLI::RequiredError("--out is required", CLI::ExitCodes::RequiredError);
  if (volume.background.empty() != volume.metric.empty())
    throw CLI::ValidationError("--background", "requires --metric and the reverse");
  if (is_model_name(volume.surface)) return run_model(volume);
  RefNames names;
  const Mesh surface = read_mesh(volume.surface, &names);
  return make_volume(volume.surface, surface, names, volume);
}

CLI::Option* add_growth(CLI::App& sub, double& growth) {
  return sub.add_option("--growth", growth, "growth ratio of edges away from the surface; default 1.3")
      ->type_name("G")
      ->check(CLI::Range(1.0, 100.0).description(""));
}

void add_sizes(CLI::App& sub, VolumeRequest& volume) {
  add_growth(sub, volume.fill.growth)->group("Sizes");
  sub.add_option("--size", volume.fill.size, "largest size; default: none")
      ->type_name("H")
      ->check(positive_number())
      ->group("Sizes");
  sub.add_option("--background", volume.background, "a tet mesh that carries the sizes of --metric")
      ->type_name("FILE")
      ->group("Sizes");
  sub.add_option("--metric", volume.metric, "sizes at the vertices of --background, instead of the surface's")
      ->type_name("FILE")
      ->group("Sizes");
}

void add_surface_options(CLI::App& sub, VolumeRequest& volume) {
  sub.add_flag("--materials", volume.fill.materials,
               "a closed surface inside a volume bounds a material, not a hole")
      ->group("Surface");
  sub.add_option("--merge", volume.fill.merge,
                 "merge points closer than this share of the diagonal; default 1e-9")
      ->type_name("T")
      ->check(CLI::Range(0.0, 0.01).description(""))
      ->group("Surface");
  sub.add_flag("--repair", volume.fill.run.repair,
               "close openings and resolve crossings, and say what was done")
      ->group("Surface");
  sub.add_flag("--remesh-surface", volume.fill.remesh_surface, "adapt the surface too, within --hausd")
      ->group("Surface");
  sub.add_option("--geometry-scale", volume.fill.geometry.model_scale,
                 "multiply a CAD model's lengths by this; default 1")
      ->type_name("S")
      ->group("Surface");
  sub.add_option("--hausd", volume.fill.geometry.hausd,
                 "largest distance to surface; default at most 0.1 % of diagonal (also -hausd)")
      ->type_name("D")
      ->check(positive_number())
      ->group("Surface");
  sub.add_option("--ridge-angle", volume.fill.geometry.ridge_angle,
                 "keep boundary edges with a sharper angle; default 45 (also -ar)")
      ->type_name("DEG")
      ->check(CLI::Range(0.0, 180.0).description(""))
      ->group("Surface");
}

void add_box(CLI::App& mesh, Action& action) {
  CLI::App* box = mesh.add_subcommand("box", "a structured box of tets");
  box->footer(kBoxFooter);
  auto command = std::make_shared<BoxCommand>();
  box->add_option("-o,-x,--out", command->output, "the mesh (also -out)")
      ->type_name("FILE")
      ->check(volume_output_name())
      ->required();
  box->add_option("--cells", command->cells,
                  "cells in x, y and z, of 6 tets each, or one number for all; default 8")
      ->type_name("NX [NY NZ]")
      ->expected(1, 3)
      ->check(CLI::Range(1, 100000).description(""));
  box->add_option("--min", command->min, "lower corner; default 0 0 0")
      ->type_name("X Y Z")
      ->check(finite_number());
  box->add_option("--max", command->max, "upper corner; default 1 1 1")
      ->type_name("X Y Z")
      ->check(finite_number());
  add_verbosity(*box, command->verbosity);
  box->callback([command, &action] { action = [command] { return run_box(*command); }; });
}

/// A body: its options and how to make its surface.
template <class Options, class MakeSurface>
void add_body(CLI::App& mesh, Action& action, const std::string& name, const std::string& help,
              const std::function<void(CLI::App&, Options&)>& declare, const MakeSurface& make_surface) {
  struct Command {
    Options options;
    VolumeRequest volume;
  };
  CLI::App* sub = mesh.add_subcommand(name, help);
  auto command = std::make_shared<Command>();
  add_volume_output(*sub, command->volume);
  sub->get_option("--out")->required();
  declare(*sub, command->options);
  sub->callback([command, make_surface, name, &action] {
    action = [command, make_surface, name] {
      return make_volume(name, make_surface(command->options, command->volume), {}, command->volume);
    };
  });
}

void add_place(CLI::App& sub, const char* name, Point& place, const char* help) {
  sub.add_option_function<std::array<double, 3>>(
         name,
         [&place](const std::array<double, 3>& x) {
           place = {x[0], x[1], x[2]};
         },
         help)
      ->type_name("X Y Z")
      ->check(finite_number());
}

void add_length(CLI::App& sub, const char* name, double& length, const char* help) {
  sub.add_option(name, length, help)->type_name("L")->check(positive_number());
}

void add_bodies(CLI::App& mesh, Action& action) {
  add_body<BallOptions>(
      mesh, action, "ball", "a ball",
      [](CLI::App& sub, BallOptions& o) {
        add_length(sub, "--radius", o.radius, "default 1");
        add_place(sub, "--center", o.center, "default 0 0 0");
        add_length(sub, "--size", o.size, "of the edges; default 0.1");
      },
      [](const BallOptions& o, VolumeRequest&) { return ball_surface(o); });
  add_body<CylinderOptions>(
      mesh, action, "cylinder", "an upright cylinder",
      [](CLI::App& sub, CylinderOptions& o) {
        add_length(sub, "--radius", o.radius, "default 1");
        add_length(sub, "--height", o.height, "default 2");
        add_place(sub, "--base", o.base, "middle of the lower end; default 0 0 0");
        add_length(sub, "--size", o.size, "of the edges; default 0.1");
      },
      [](const CylinderOptions& o, VolumeRequest&) { return cylinder_surface(o); });
  struct Wing {
    DeltaWingOptions surface;
    double growth = 1.3, far_size = 0;
  };
  add_body<Wing>(
      mesh, action, "delta-wing", "UGAWG's delta wing in its far-field box",
      [](CLI::App& sub, Wing& o) {
        add_length(sub, "--size", o.surface.size, "of the edges on the wing; default: as coarse as possible");
        add_length(sub, "--far-size", o.far_size, "largest size; default: none");
        add_growth(sub, o.growth);
      },
      [](const Wing& o, VolumeRequest& volume) {
        volume.fill.remesh_surface = true;
        volume.fill.growth = o.growth;
        volume.fill.size = o.far_size;
        return delta_wing_surface(o.surface);
      });
}

/// What is given to `weft mesh` itself would count for nothing where a body follows.
void refuse_before(const std::string& body, const CLI::App& mesh) {
  for (const CLI::Option* option : mesh.get_options()) {
    if (option->count() == 0 || option == mesh.get_help_ptr()) continue;
    throw CLI::ValidationError(
        option->get_name(),
        (option->get_positional() ? "is not taken together with `" : "belongs after `") + body + "`");
  }
}

}  // namespace

void add_mesh_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("mesh", "make an initial mesh of a surface or of a simple body");
  sub->footer(kMeshFooter);
  auto volume = std::make_shared<VolumeRequest>();
  sub->add_option("SURFACE", volume->surface, "closed triangles in any format, or a CAD model")
      ->type_name("FILE");
  add_volume_output(*sub, *volume);
  add_sizes(*sub, *volume);
  add_surface_options(*sub, *volume);
  add_box(*sub, action);
  add_bodies(*sub, action);
  for (CLI::App* body : sub->get_subcommands([](CLI::App*) { return true; }))
    body->preparse_callback([sub, body](std::size_t) { refuse_before(body->get_name(), *sub); });
  sub->callback([sub, volume, &action] {
    if (sub->get_subcommands().empty()) action = [volume] { return run_surface(*volume); };
  });
}

}  // namespace weft::tools

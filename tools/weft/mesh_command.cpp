// `weft mesh`: initial meshes; so far the structured box.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <memory>

#include "meshing/io/mesh_file.h"
#include "meshing/structured_box.h"
#include "tools/weft/commands.h"
#include "tools/weft/exit_codes.h"
#include "tools/weft/option_checks.h"
#include "tools/weft/outputs.h"
#include "tools/weft/text.h"

namespace weft::tools {
namespace {

constexpr const char* kFooter = R"(Example:
  weft mesh box -o cube.meshb --cells 8 8 8

References of the triangles: 1 x-min, 2 x-max, 3 y-min, 4 y-max, 5 z-min, 6 z-max. The box's 12
edges are ridges, its 8 corners corners.)";

struct BoxCommand {
  std::string output;
  std::array<std::uint32_t, 3> cells = {8, 8, 8};
  std::array<double, 3> min = {0, 0, 0}, max = {1, 1, 1};
};

int run_box(const BoxCommand& command) {
  const auto point = [](const std::array<double, 3>& x) { return meshing::Point{x[0], x[1], x[2]}; };
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!(command.min[axis] < command.max[axis]))
      throw CLI::ValidationError("--max", "must lie above --min in every direction");
  check_writable(command.output);
  const meshing::MeshData mesh =
      meshing::structured_box({command.cells, point(command.min), point(command.max)});
  meshing::write_mesh(command.output, mesh);
  fmt::print("{}: {} vertices, {} tets\n", command.output, grouped(std::uint64_t{mesh.points.size()}),
             grouped(std::uint64_t{mesh.tets.size()}));
  return kDone;
}

}  // namespace

void add_mesh_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("mesh", "make a start mesh: a structured box");
  sub->require_subcommand(1);
  sub->footer(kFooter);
  CLI::App* box = sub->add_subcommand("box", "a structured box of tets");
  box->footer(kFooter);
  auto command = std::make_shared<BoxCommand>();
  box->add_option("-o,-x,--out", command->output, "the mesh (also -out)")
      ->type_name("FILE")
      ->check(volume_output_name())
      ->required();
  box->add_option("--cells", command->cells, "cells in x, y and z, of 6 tets each; default 8 8 8")
      ->type_name("NX NY NZ")
      ->check(CLI::Range(1, 100000).description(""));
  box->add_option("--min", command->min, "lower corner; default 0 0 0")
      ->type_name("X Y Z")
      ->check(finite_number());
  box->add_option("--max", command->max, "upper corner; default 1 1 1")
      ->type_name("X Y Z")
      ->check(finite_number());
  box->callback([command, &action] { action = [command] { return run_box(*command); }; });
}

}  // namespace weft::tools

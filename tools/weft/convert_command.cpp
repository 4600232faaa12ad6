// `weft convert`: from one file format to another.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "meshing/error.h"
#include "meshing/io/mesh_file.h"
#include "tools/weft/commands.h"
#include "tools/weft/exit_codes.h"
#include "tools/weft/option_checks.h"
#include "tools/weft/outputs.h"
#include "tools/weft/text.h"

namespace weft::tools {
namespace {

using meshing::MeshData;
using meshing::SolutionData;

constexpr const char* kFooter = R"(Example:
  weft convert fine.meshb fine.vtu --sol fine.solb

Reads .meshb (versions 1 to 4, either byte order) and .mesh; writes .meshb, .mesh and .vtu. The
fields of --sol go into the .vtu, or beside a .meshb into a .solb and beside a .mesh into a .sol.
Says what the new format cannot hold.)";

struct ConvertCommand {
  std::string input, output, solution;
};

/// What of a mesh a VTU file does not hold, as "NAME: COUNT" lines.
std::string dropped_text(const MeshData& mesh) {
  std::string text;
  const auto line = [&](const char* name, std::size_t n) {
    if (n > 0) text += fmt::format("dropped: {} {}\n", grouped(std::uint64_t{n}), name);
  };
  line("triangles", mesh.triangles.size());
  line("edges", mesh.edges.size());
  line("corners", mesh.corners.size());
  line("ridges", mesh.ridges.size());
  line("required vertices", mesh.required_points.size());
  line("required edges", mesh.required_edges.size());
  line("required triangles", mesh.required_triangles.size());
  std::size_t refs = 0;
  for (const std::int32_t ref : mesh.point_refs) refs += ref != 0;
  line("vertex references", refs);
  return text;
}

int run_convert(const ConvertCommand& command) {
  check_writable(command.output);
  const MeshData mesh = meshing::read_mesh(command.input);
  const bool vtu = std::filesystem::path(command.output).extension() == ".vtu";
  if (command.solution.empty()) {
    meshing::write_mesh(command.output, mesh);
  } else {
    const SolutionData solution = meshing::read_solution(command.solution);
    if (solution.num_points != mesh.points.size())
      throw meshing::InputError(command.solution, "",
                                fmt::format("is the solution of another mesh: it has {} vertices, {} has {}",
                                            grouped(std::uint64_t{solution.num_points}), command.input,
                                            grouped(std::uint64_t{mesh.points.size()})));
    if (vtu) {
      meshing::write_mesh(command.output, mesh, &solution);
    } else {
      write_mesh_with_solution(output_paths(command.output), mesh, solution);
    }
  }
  fmt::print("{}: {} vertices, {} tets\n", command.output, grouped(std::uint64_t{mesh.points.size()}),
             grouped(std::uint64_t{mesh.tets.size()}));
  if (vtu) fmt::print("{}", dropped_text(mesh));
  return kDone;
}

}  // namespace

void add_convert_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("convert", "convert a mesh and its fields to another format");
  sub->footer(kFooter);
  auto command = std::make_shared<ConvertCommand>();
  sub->add_option("IN", command->input, "the mesh, .meshb or .mesh")->type_name("FILE")->required();
  sub->add_option("OUT", command->output, "the result, .meshb, .mesh or .vtu")
      ->type_name("FILE")
      ->check(mesh_output_name())
      ->required();
  sub->add_option("--sol,--metric", command->solution,
                  "fields at the vertices, .solb or .sol (also -sol, -met)")
      ->type_name("FILE");
  sub->callback([command, &action] { action = [command] { return run_convert(*command); }; });
}

}  // namespace weft::tools

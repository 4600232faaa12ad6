// `weft interpolate`: fields of one mesh at the vertices of another.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "meshing/error.h"
#include "meshing/interpolate.h"
#include "meshing/io/mesh_file.h"
#include "tools/weft/commands.h"
#include "tools/weft/exit_codes.h"
#include "tools/weft/named_error.h"
#include "tools/weft/option_checks.h"
#include "tools/weft/outputs.h"
#include "tools/weft/text.h"

namespace weft::tools {
namespace {

using meshing::MeshData;
using meshing::SolutionData;

constexpr const char* kFooter = R"(Example:
  weft interpolate wing.meshb fine.meshb --field mach.solb -o fine-mach.solb

Linear in the tets of FROM, exact for linear fields; vertices of TO outside FROM get the value of its
closest point. Says how far the integral of each field over the mesh changes.)";

struct InterpolateCommand {
  std::string from, to, output;
  std::vector<std::string> fields;
};

/// All fields of all files, which must belong to `mesh`.
SolutionData read_fields(const InterpolateCommand& command, const MeshData& mesh) {
  SolutionData all{mesh.points.size(), {}};
  for (const std::string& file : command.fields) {
    SolutionData solution = meshing::read_solution(file);
    if (solution.num_points != all.num_points)
      throw meshing::InputError(file, "",
                                fmt::format("solution of another mesh: it has {} vertices, {} has {}",
                                            solution.num_points, command.from, all.num_points));
    std::ranges::move(solution.fields, std::back_inserter(all.fields));
  }
  return all;
}

void print_integrals(const MeshData& from, const SolutionData& before, const MeshData& to,
                     const SolutionData& after) {
  for (std::size_t f = 0; f < before.fields.size(); ++f) {
    const auto old_sums = meshing::integrals(from, before.fields[f]);
    const auto new_sums = meshing::integrals(to, after.fields[f]);
    for (std::size_t c = 0; c < old_sums.size(); ++c) {
      const std::string name = old_sums.size() == 1 ? fmt::format("field {}", f + 1)
                                                    : fmt::format("field {}, component {}", f + 1, c + 1);
      fmt::print("{}: integral {:.6g}, before {:.6g}\n", name, new_sums[c], old_sums[c]);
    }
  }
}

int run_interpolate(const InterpolateCommand& command) {
  check_writable(command.output);
  const MeshData from = meshing::read_mesh(command.from), to = meshing::read_mesh(command.to);
  const SolutionData fields = read_fields(command, from);
  const meshing::Interpolation result =
      naming(command.from, [&] { return meshing::interpolate(from, fields, to); });
  meshing::write_solution(command.output, result.fields);
  fmt::print("{}: {} fields at {} vertices\n", command.output, fields.fields.size(),
             grouped(std::uint64_t{to.points.size()}));
  print_integrals(from, fields, to, result.fields);
  if (result.outside > 0)
    fmt::print("warning: {} vertices lie outside {}, up to {:.3g} from it\n", grouped(result.outside),
               command.from, result.farthest);
  return kDone;
}

}  // namespace

void add_interpolate_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("interpolate", "carry fields from one mesh to another");
  sub->footer(kFooter);
  auto command = std::make_shared<InterpolateCommand>();
  sub->add_option("FROM", command->from, "the mesh that the fields belong to")->type_name("FILE")->required();
  sub->add_option("TO", command->to, "the mesh that they are wanted on")->type_name("FILE")->required();
  sub->add_option("--field", command->fields, "fields at the vertices of FROM, .solb or .sol; repeatable")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->required();
  sub->add_option("-o,-x,--out", command->output,
                  "the fields at the vertices of TO, .solb or .sol (also -out)")
      ->type_name("FILE")
      ->check(solution_name())
      ->required();
  sub->callback([command, &action] { action = [command] { return run_interpolate(*command); }; });
}

}  // namespace weft::tools

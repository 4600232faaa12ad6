// `weft interpolate`: fields of one mesh at the vertices of another.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tools/common/field_text.h"
#include "tools/common/inputs.h"
#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/field_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/on_ranks.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kInterpolateFooter = R"(Example:
  weft interpolate wing.meshb fine.meshb --field mach.solb -o fine-mach.solb --transfer conservative

Linear interpolation is exact for linear fields. The conservative transfer is too; it also preserves the
integral of every component to 1e-12 of that of its absolute value and creates no new extrema. Vertices
of TO outside FROM get the value of the closest point. Printed for every component: its integral and its
relative change, and the differences after interpolation back to FROM, in the L2 and the maximum norm,
relative to the norm of the field.)";

struct InterpolateCommand {
  std::string from, to, output;
  FieldChoice fields;
  int threads = 1;
  Verbosity verbosity;
};

void tell(const InterpolateCommand& command, std::size_t fields, std::uint64_t vertices,
          const Transfer& result) {
  command.verbosity.print("{}: {} at {}\n", command.output, counted(fields, "field"),
                          counted(vertices, "vertex"));
  command.verbosity.print("{}", accounts_text(result.accounts, command.fields.method));
  for (const std::string& warning : transfer_warnings(result, command.from))
    command.verbosity.print("warning: {}\n", warning);
}

int run_on_ranks(const InterpolateCommand& command) {
  const TransferOnRanks done = interpolate_on_ranks(command.from, command.fields.files, command.to,
                                                    command.output, command.fields.method, command.threads);
  if (!done.first) return kDone;
  for (const std::string& warning : done.warnings) command.verbosity.print("warning: {}\n", warning);
  tell(command, done.fields, done.vertices, done.transfer);
  return kDone;
}

int run_interpolate(const InterpolateCommand& command) {
  keep_inputs(command.output, "it", command.fields.files);
  if (under_mpirun()) return run_on_ranks(command);
  check_writable(command.output);
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  const Mesh from = read_mesh(command.from), to = read_mesh(command.to);
  const Fields fields = read_fields(command.fields.files, from.points.size(), command.from);
  progress.phase("fields");
  const Transfer result =
      interpolate(from, fields, to, command.fields.method, command.threads, command.from, command.to);
  progress.phase("writing");
  write_fields(command.output, result.fields);
  progress.finish();
  tell(command, fields.fields.size(), to.points.size(), result);
  return kDone;
}

}  // namespace

void add_interpolate_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("interpolate", "transfer fields from one mesh to another");
  sub->footer(kInterpolateFooter);
  auto command = std::make_shared<InterpolateCommand>();
  sub->add_option("FROM", command->from, "the mesh that the fields belong to")->type_name("FILE")->required();
  sub->add_option("TO", command->to, "the mesh to transfer them to")->type_name("FILE")->required();
  add_field_options(*sub, command->fields, "FROM", "Options")->required();
  sub->add_option("-o,-x,--out", command->output,
                  "the fields at the vertices of TO, .solb or .sol (also -out)")
      ->type_name("FILE")
      ->check(solution_name())
      ->required();
  add_threads(*sub, command->threads);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_interpolate(*command); }; });
}

}  // namespace weft::tools

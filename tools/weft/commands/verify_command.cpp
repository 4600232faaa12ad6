// `weft verify`: does a mesh conform, and does it fill the same space as another.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/on_ranks.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

using ByRef = std::map<std::int32_t, double>;

constexpr const char* kVerifyFooter = R"(Example:
  weft verify fine.meshb --against wing.meshb

Checks with exact arithmetic that every tet is positively oriented, that every face is shared by two
tets or covered by one boundary triangle, and that indices, edges and references are valid.
--against: volumes and areas by reference must agree with the other mesh to 1e-9 relative, as they do
where the boundary is planar; on curved boundaries they differ slightly.
Exit codes (with --quiet the only output): 0 conforms, 1 does not, 2 cannot be read.)";

struct VerifyCommand {
  std::string mesh, against;
  Verbosity verbosity;
};

std::string exact_by_ref_text(const char* what, const ByRef& by_ref) {
  std::string text;
  for (const auto& [ref, value] : by_ref)
    text += fmt::format("  {} of reference {:<10}{:>24.15g}\n", what, ref, value);
  return text;
}

std::string report_text(const std::string& name, const CheckReport& report) {
  std::string text = fmt::format("{}\n  components{:<26}{:>8}\n  volume{:<20}{:>24.15g}\n", name, "",
                                 report.num_components, "", report.volume);
  if (report.volume_by_ref.size() > 1) text += exact_by_ref_text("volume", report.volume_by_ref);
  text += exact_by_ref_text("area  ", report.area_by_ref);
  if (report.unreferenced_points > 0)
    text += fmt::format("  vertices that no tet uses: {}\n", grouped(report.unreferenced_points));
  if (report.touching_edges + report.touching_vertices > 0)
    text += fmt::format("  the body touches itself at {} edges and {} vertices\n",
                        grouped(report.touching_edges), grouped(report.touching_vertices));
  for (const std::string& problem : report.problems) text += fmt::format("  PROBLEM: {}\n", problem);
  if (report.num_problems > report.problems.size())
    text += fmt::format("  and {} more\n", grouped(report.num_problems - report.problems.size()));
  return text;
}

/// By all ranks of mpirun in shares, else by this process.
VerifiedOnRanks check_files(const VerifyCommand& command) {
  if (under_mpirun()) return verify_on_ranks(command.mesh, command.against);
  Progress progress(command.verbosity.style());
  progress.phase("checking");
  VerifiedOnRanks done;
  done.report = verify(read_mesh(command.mesh));
  if (!command.against.empty()) {
    progress.phase("checking the other mesh");
    done.against = verify(read_mesh(command.against), 0);
  }
  progress.finish();
  return done;
}

int run_verify(const VerifyCommand& command) {
  const VerifiedOnRanks done = check_files(command);
  if (!done.first) return kDone;
  for (const std::string& warning : done.warnings)
    if (!command.verbosity.quiet) fmt::print(stderr, "warning: {}\n", warning);
  std::string text = report_text(command.mesh, done.report);
  std::vector<std::string> found;
  if (done.against) {
    found = differences(done.report, *done.against);
    text += fmt::format("against {}\n", command.against);
    if (found.empty()) text += "  volumes and areas are the same\n";
    for (const std::string& difference : found) text += fmt::format("  PROBLEM: {}\n", difference);
  }
  const bool good = done.report.ok() && found.empty();
  command.verbosity.print("{}{}\n", text, good ? "conforms" : "DOES NOT CONFORM");
  return good ? kDone : kGoalNotMet;
}

}  // namespace

void add_verify_command(CLI::App& app, Action& action) {
  CLI::App* sub =
      app.add_subcommand("verify", "check that a mesh conforms, and compare its volumes with another mesh");
  sub->footer(kVerifyFooter);
  auto command = std::make_shared<VerifyCommand>();
  sub->add_option("MESH", command->mesh, "the mesh")->type_name("FILE")->required();
  sub->add_option("--against", command->against, "another mesh of the same domain")->type_name("FILE");
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_verify(*command); }; });
}

}  // namespace weft::tools

// `weft verify`: does a mesh conform, and does it fill the same space as another.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
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

/// A line for each reference at which two meshes differ.
std::string differences_text(const char* what, const ByRef& ours, const ByRef& theirs) {
  constexpr double kTolerance = 1e-9;
  std::set<std::int32_t> refs;
  for (const auto& [ref, value] : ours) refs.insert(ref);
  for (const auto& [ref, value] : theirs) refs.insert(ref);
  const auto value_at = [](const ByRef& by_ref, std::int32_t ref) {
    const auto at = by_ref.find(ref);
    return at == by_ref.end() ? 0.0 : at->second;
  };
  std::string text;
  for (const std::int32_t ref : refs) {
    const double a = value_at(ours, ref), b = value_at(theirs, ref);
    const double relative = a == b ? 0 : std::abs(a - b) / std::max(std::abs(a), std::abs(b));
    if (relative <= kTolerance) continue;
    text += fmt::format("  PROBLEM: {} of reference {} is {:.15g}, the other mesh's {:.15g}: {:.2g} apart\n",
                        what, ref, a, b, relative);
  }
  return text;
}

/// A body must not come to touch itself where it did not, nor come apart: a line for each figure that
/// differs.
std::string touching_text(const CheckReport& ours, const CheckReport& theirs) {
  std::string text;
  const auto compare = [&](const char* what, std::uint64_t a, std::uint64_t b) {
    if (a == b) return;
    text += fmt::format("  PROBLEM: the body touches itself at {} {}, the other mesh's at {}\n", grouped(a),
                        what, grouped(b));
  };
  compare("edges", ours.touching_edges, theirs.touching_edges);
  compare("vertices", ours.touching_vertices, theirs.touching_vertices);
  return text;
}

int run_verify(const VerifyCommand& command) {
  Progress progress(command.verbosity.style());
  progress.phase("checking");
  const CheckReport report = verify(read_mesh(command.mesh));
  std::string text = report_text(command.mesh, report), differences;
  if (!command.against.empty()) {
    progress.phase("checking the other mesh");
    const CheckReport other = verify(read_mesh(command.against), 0);
    const std::string sums = differences_text("volume", report.volume_by_ref, other.volume_by_ref) +
                             differences_text("area", report.area_by_ref, other.area_by_ref);
    differences = sums + touching_text(report, other);
    text += fmt::format("against {}\n", command.against) +
            (sums.empty() ? "  volumes and areas are the same\n" : "") + differences;
  }
  progress.finish();
  const bool good = report.ok() && differences.empty();
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

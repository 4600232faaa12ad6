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
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

using ByRef = std::map<std::int32_t, double>;

constexpr const char* kFooter = R"(Example:
  weft verify fine.meshb --against wing.meshb

Checks with exact arithmetic that every tet is positively oriented, that every face is shared by two
tets or tracked by one boundary triangle, and that indices, edges and references are in order.
--against: volumes and areas by reference must equal the other mesh's to 1e-9 relative (true where
the boundary is planar; on curved boundaries they differ a little).
Exit codes: 0 conforms, 1 does not, 2 cannot be read.)";

struct VerifyCommand {
  std::string mesh, against;
};

void print_by_ref(const char* what, const ByRef& by_ref) {
  for (const auto& [ref, value] : by_ref)
    fmt::print("  {} of reference {:<10}{:>24.15g}\n", what, ref, value);
}

void print_report(const std::string& name, const CheckReport& report) {
  fmt::print("{}\n  components{:<26}{:>8}\n  volume{:<20}{:>24.15g}\n", name, "", report.num_components, "",
             report.volume);
  if (report.volume_by_ref.size() > 1) print_by_ref("volume", report.volume_by_ref);
  print_by_ref("area  ", report.area_by_ref);
  if (report.unreferenced_points > 0)
    fmt::print("  vertices that no tet uses: {}\n", grouped(report.unreferenced_points));
  if (report.touching_edges + report.touching_vertices > 0)
    fmt::print("  the body touches itself at {} edges and {} vertices\n", grouped(report.touching_edges),
               grouped(report.touching_vertices));
  for (const std::string& problem : report.problems) fmt::print("  PROBLEM: {}\n", problem);
  if (report.num_problems > report.problems.size())
    fmt::print("  and {} more\n", grouped(report.num_problems - report.problems.size()));
}

/// Prints the references at which two meshes differ; returns how many.
int print_differences(const char* what, const ByRef& ours, const ByRef& theirs) {
  constexpr double kTolerance = 1e-9;
  std::set<std::int32_t> refs;
  for (const auto& [ref, value] : ours) refs.insert(ref);
  for (const auto& [ref, value] : theirs) refs.insert(ref);
  const auto value_at = [](const ByRef& by_ref, std::int32_t ref) {
    const auto at = by_ref.find(ref);
    return at == by_ref.end() ? 0.0 : at->second;
  };
  int differences = 0;
  for (const std::int32_t ref : refs) {
    const double a = value_at(ours, ref), b = value_at(theirs, ref);
    const double relative = a == b ? 0 : std::abs(a - b) / std::max(std::abs(a), std::abs(b));
    if (relative <= kTolerance) continue;
    fmt::print("  PROBLEM: {} of reference {} is {:.15g}, the other mesh's {:.15g}: {:.2g} apart\n", what,
               ref, a, b, relative);
    ++differences;
  }
  return differences;
}

/// A body must not come to touch itself where it did not, nor come apart; returns how many figures differ.
int print_touching(const CheckReport& ours, const CheckReport& theirs) {
  int differences = 0;
  const auto compare = [&](const char* what, std::uint64_t a, std::uint64_t b) {
    if (a == b) return;
    fmt::print("  PROBLEM: the body touches itself at {} {}, the other mesh's at {}\n", grouped(a), what,
               grouped(b));
    ++differences;
  };
  compare("edges", ours.touching_edges, theirs.touching_edges);
  compare("vertices", ours.touching_vertices, theirs.touching_vertices);
  return differences;
}

int run_verify(const VerifyCommand& command) {
  const CheckReport report = verify(read_mesh(command.mesh));
  print_report(command.mesh, report);
  int differences = 0;
  if (!command.against.empty()) {
    const CheckReport other = verify(read_mesh(command.against), 0);
    fmt::print("against {}\n", command.against);
    differences += print_differences("volume", report.volume_by_ref, other.volume_by_ref);
    differences += print_differences("area", report.area_by_ref, other.area_by_ref);
    if (differences == 0) fmt::print("  volumes and areas are the same\n");
    differences += print_touching(report, other);
  }
  const bool good = report.ok() && differences == 0;
  fmt::print("{}\n", good ? "conforms" : "DOES NOT CONFORM");
  return good ? kDone : kGoalNotMet;
}

}  // namespace

void add_verify_command(CLI::App& app, Action& action) {
  CLI::App* sub =
      app.add_subcommand("verify", "check that a mesh conforms, and its volumes against another's");
  sub->footer(kFooter);
  auto command = std::make_shared<VerifyCommand>();
  sub->add_option("MESH", command->mesh, "the mesh")->type_name("FILE")->required();
  sub->add_option("--against", command->against, "a mesh of the same domain")->type_name("FILE");
  sub->callback([command, &action] { action = [command] { return run_verify(*command); }; });
}

}  // namespace weft::tools

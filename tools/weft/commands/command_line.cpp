// Parses the arguments, runs the subcommand, and turns errors into messages and exit codes.
#include "tools/weft/commands/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iterator>
#include <new>
#include <string_view>
#include <thread>

#include "tools/weft/commands/commands.h"
#include "tools/weft/options/arguments.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/help.h"
#include "tools/weft/terminal/help_data.h"
#include "weft/on_ranks.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kTopFooter = R"(Example:
  weft adapt wing.meshb --metric wing.solb --complexity 500000 -o fine.meshb --threads 8

`weft SUBCOMMAND --help` shows the options of a subcommand.
Meshes are .meshb or .mesh (Gamma Mesh Format, as refine, Mmg and Gmsh write it),
.msh, .ugrid, .su2, .vtu, .pvtu or .cgns; metrics and solutions are .solb or .sol,
or fields in a .msh, .vtu, .pvtu or .cgns.
Exit codes: 0 success; 1 valid mesh, but the goal was not met (`verify`: it does not conform); 2 no mesh;
64 usage error.)";

/// For the build alone, which makes man pages, shell completion and the command reference of it.
constexpr const char* kHelpData = "--help-data";

/// mpirun ends all ranks when one has ended with an error: the one that says why gets a moment for its words.
void wait_for_words() { std::this_thread::sleep_for(std::chrono::milliseconds(300)); }

/// Before an error of arguments is told. Ranks have the same ones: the first tells it, and its end ends the
/// others, unless it has no error.
void let_first_speak() {
  if (place_on_ranks().rank != 0) std::this_thread::sleep_for(std::chrono::seconds(5));
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(subcommand->get_name());
  return names;
}

/// Says which subcommand was meant: the parser alone would only call the word unexpected.
bool report_unknown_subcommand(const CLI::App& app, const std::vector<std::string>& arguments) {
  const std::vector<std::string> names = subcommand_names(app);
  if (arguments[0].starts_with("-")) return false;
  if (std::find(names.begin(), names.end(), arguments[0]) != names.end()) return false;
  const std::string closest = closest_word(arguments[0], names);
  const std::string hint = closest.empty() ? "see `weft --help`" : "did you mean `weft " + closest + "`?";
  fmt::print(stderr, "weft: no subcommand '{}': {}\n", arguments[0], hint);
  return true;
}

int report_parse_error(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {  // --help, --version
    if (place_on_ranks().rank == 0) app.exit(error);
    return kDone;
  }
  let_first_speak();
  std::string command = "weft";
  for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
    at = at->get_subcommands().front();
    command += " " + at->get_name();
  }
  fmt::print(stderr, "{}: {}\nSee `{} --help`.\n", command, error.what(), command);
  return kUsage;
}

/// Under mpirun what these do not do together is done once, by the first.
bool is_done_by_first(const std::string& subcommand) {
  constexpr std::string_view kTogether[] = {"adapt", "stat", "metric", "interpolate", "convert", "verify"};
  return under_mpirun() && std::ranges::find(kTogether, subcommand) == std::end(kTogether);
}

int run_action(const Action& action) {
  try {
    return action();
  } catch (const CLI::ParseError&) {
    throw;
  } catch (const OptionError& error) {
    throw CLI::ValidationError(error.option(), error.reason());
  } catch (const RunError& error) {
    if (!error.reported()) fmt::print(stderr, "weft: {}\n", printable(error.what()));
    if (error.reported()) wait_for_words();
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "weft: out of memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "weft: {}\n", printable(error.what()));
  }
  return kNoMesh;
}

}  // namespace

std::string done_by_first(const std::string& what) {
  return "warning: rank 0 alone does `weft " + what + "`, with all of the mesh; the other ranks do nothing\n";
}

int run_command_line(const std::vector<std::string>& arguments) {
  CLI::App app("weft adapts tetrahedral meshes to anisotropic metric fields.", "weft");
  Action action;
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_version_flag(
      "--version", [] { return version_details(); }, "versions of weft and its libraries");
  app.require_subcommand(1);
  app.footer(kTopFooter);
  add_adapt_command(app, action, arguments);
  add_stat_command(app, action);
  add_verify_command(app, action);
  add_metric_command(app, action);
  add_mesh_command(app, action);
  add_convert_command(app, action);
  add_interpolate_command(app, action);
  add_view_command(app, action);
  add_graph_command(app, action);
  add_replay_command(app, action);
  add_report_command(app, action);
  add_loop_command(app, action);
  if (!arguments.empty() && is_done_by_first(arguments[0]) && place_on_ranks().rank != 0) return kDone;
  if (arguments.empty()) {
    let_first_speak();
    fmt::print(stderr, "{}", app.help());
    return kUsage;
  }
  if (arguments == std::vector<std::string>{kHelpData}) {
    fmt::print("{}\n", help_data(app));
    return kDone;
  }
  if (report_unknown_subcommand(app, arguments)) return kUsage;
  try {
    std::vector<std::string> reversed = translate_aliases(arguments);
    std::reverse(reversed.begin(), reversed.end());  // the order that CLI11 takes a vector in
    app.parse(std::move(reversed));
    const bool quiet = std::ranges::find(arguments, "--quiet") != arguments.end();
    if (is_done_by_first(arguments[0]) && place_on_ranks().ranks > 1 && arguments[0] != "loop" && !quiet)
      fmt::print(stderr, "{}", done_by_first(arguments[0]));
    return run_action(action);
  } catch (const CLI::ParseError& error) {
    return report_parse_error(app, error);
  }
}

}  // namespace weft::tools

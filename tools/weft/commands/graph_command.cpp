// `weft graph`: a dump of a run, filtered, in the formats of graph tools or drawn by Graphviz.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "tools/common/inputs.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kGraphFooter = R"(Examples:
  weft graph run/graph.json --collapse rounds -o rounds.svg
  weft graph run/graph.json --critical-path -o path.svg
  weft graph run/graph.json --round 2 --subdomain 17 --format graphml > part.graphml
  weft graph run/graph.json --plan -o plan.svg

FILE is the graph.json or profile.json of `weft adapt --report DIR`, or a .json of `weft adapt --graph`.
Without -o the graph is printed (not with --quiet). The format follows from --format or the extension of the
output. Rounds count from 0.)";

struct GraphCommand {
  std::string file, output, format;
  GraphFilter filter;
  Verbosity verbosity;
};

std::string format_of(const GraphCommand& command) {
  if (!command.format.empty()) return command.format;
  if (command.output.empty()) return "dot";
  std::string named = graph_format(command.output);
  if (!named.empty()) return named;
  throw CLI::ValidationError("--out", "'" + command.output + "' must end in .dot, .graphml, .json or .svg");
}

int run_graph(const GraphCommand& command) {
  const std::string format = format_of(command);
  keep_inputs(command.output, "it", {command.file});
  if (!command.output.empty()) check_writable(command.output);
  Progress progress(command.verbosity.style());
  progress.phase("drawing");
  const std::string text = graph_text(command.file, format, command.filter);
  progress.finish();
  if (command.output.empty())
    command.verbosity.print("{}", text);
  else
    write_text(command.output, text);
  return kDone;
}

void add_filters(CLI::App& sub, GraphCommand& command) {
  constexpr const char* kGroup = "Filters";
  sub.add_option("--round", command.filter.round, "only tasks of this round")->type_name("N")->group(kGroup);
  sub.add_option("--subdomain", command.filter.subdomain, "only tasks of this subdomain")
      ->type_name("N")
      ->group(kGroup);
  sub.add_flag("--critical-path", command.filter.critical_path, "only the critical path")->group(kGroup);
  sub.add_option("--collapse", command.filter.collapse,
                 "merge tasks: none (default), rounds (by node and round) or subdomains")
      ->check(CLI::IsMember({"none", "rounds", "subdomains"}).description(""))
      ->type_name("BY")
      ->group(kGroup);
  sub.add_flag("--plan", command.filter.plan, "the planned graph, which is the same for every subdomain")
      ->group(kGroup);
}

}  // namespace

void add_graph_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("graph", "filter and draw the task graph of a run");
  sub->footer(kGraphFooter);
  auto command = std::make_shared<GraphCommand>();
  sub->add_option("FILE", command->file, "the recorded graph")->type_name("FILE")->required();
  sub->add_option("-o,-x,--out", command->output, "the result; default: standard output (also -out)")
      ->type_name("FILE");
  sub->add_option("--format", command->format, "dot, graphml, json or svg (needs Graphviz)")
      ->check(CLI::IsMember({"dot", "graphml", "json", "svg"}).description(""))
      ->type_name("FORMAT");
  add_filters(*sub, *command);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_graph(*command); }; });
}

}  // namespace weft::tools

// `weft graph`: a dump of a run, filtered, in the formats of graph tools or drawn by Graphviz.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/dataflow/dump/graph_drawing.h"
#include "graph/dataflow/dump/graph_json.h"
#include "meshing/base/error.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/jobs/named_error.h"
#include "tools/weft/jobs/outputs.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/report/graph_output.h"
#include "tools/weft/report/json_file.h"
#include "tools/weft/terminal/exit_codes.h"

namespace weft::tools {
namespace {

using graph::dataflow::Collapse;
using graph::dataflow::drawing_of;
using graph::dataflow::GraphDump;
using Json = nlohmann::ordered_json;

constexpr const char* kFooter = R"(Examples:
  weft graph run/graph.json --collapse rounds -o rounds.svg
  weft graph run/graph.json --critical-path -o path.svg
  weft graph run/graph.json --round 2 --subdomain 17 --format graphml > part.graphml
  weft graph run/graph.json --plan -o plan.svg

FILE is the graph.json or profile.json of `weft adapt --report DIR`, or a .json of `weft adapt --graph`.
Without -o the graph is printed (not with --quiet). The format follows from --format or the extension of the
output. Rounds count from 0.)";

struct GraphCommand {
  std::string file, output;
  std::optional<GraphFormat> format;
  graph::dataflow::DumpFilter filter;
  Collapse collapse = Collapse::none;
  bool plan = false;
  Verbosity verbosity;
};

GraphFormat format_of(const GraphCommand& command) {
  if (command.format) return *command.format;
  if (command.output.empty()) return GraphFormat::dot;
  if (const auto named = graph_format(command.output)) return *named;
  throw CLI::ValidationError("--out", "'" + command.output + "' must end in .dot, .graphml, .json or .svg");
}

GraphDump read_dump(const std::string& path) {
  Json json = read_json(path);
  if (json.is_object() && json.value("schema", "") == "weft-profile-1") {
    Json inner = std::move(json["graph"]);
    if (inner.is_null()) throw meshing::InputError(path, "", "contains no graph: the run recorded none");
    json = std::move(inner);
  }
  try {
    return graph::dataflow::dump_from_json(json);
  } catch (const std::invalid_argument& error) {
    throw meshing::InputError(path, "", error.what());
  }
}

int run_graph(const GraphCommand& command) {
  const GraphFormat format = format_of(command);
  if (!command.output.empty()) check_writable(command.output);
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  const GraphDump all = read_dump(command.file);
  const GraphDump dump = [&] {
    try {
      return filtered(all, command.filter);
    } catch (const std::invalid_argument& error) {
      throw meshing::InputError(command.file, "", error.what());
    }
  }();
  progress.phase("drawing");
  const std::string text = naming(command.file, [&] {
    return command.plan && format != GraphFormat::json ? drawing_text(drawing_of(dump.description), format)
                                                       : graph_text(dump, format, command.collapse);
  });
  progress.finish();
  if (command.output.empty())
    command.verbosity.print("{}", text);
  else
    write_text(command.output, text);
  return kDone;
}

void add_filters(CLI::App& sub, GraphCommand& command) {
  constexpr const char* kGroup = "Filters";
  static const std::map<std::string, Collapse> collapses = {
      {"none", Collapse::none}, {"rounds", Collapse::rounds}, {"subdomains", Collapse::instances}};
  sub.add_option("--round", command.filter.round, "only tasks of this round")->type_name("N")->group(kGroup);
  sub.add_option("--subdomain", command.filter.instance, "only tasks of this subdomain")
      ->type_name("N")
      ->group(kGroup);
  sub.add_flag("--critical-path", command.filter.critical_path_only, "only the critical path")->group(kGroup);
  sub.add_option("--collapse", command.collapse,
                 "merge tasks: none (default), rounds (by node and round) or subdomains")
      ->transform(CLI::CheckedTransformer(collapses).description(""))
      ->type_name("BY")
      ->group(kGroup);
  sub.add_flag("--plan", command.plan, "the planned graph, which is the same for every subdomain")
      ->group(kGroup);
}

}  // namespace

void add_graph_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("graph", "filter and draw the task graph of a run");
  sub->footer(kFooter);
  auto command = std::make_shared<GraphCommand>();
  sub->add_option("FILE", command->file, "the recorded graph")->type_name("FILE")->required();
  sub->add_option("-o,-x,--out", command->output, "the result; default: standard output (also -out)")
      ->type_name("FILE");
  sub->add_option("--format", command->format, "dot, graphml, json or svg (needs Graphviz)")
      ->transform(CLI::CheckedTransformer(graph_formats()).description(""))
      ->type_name("FORMAT");
  add_filters(*sub, *command);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_graph(*command); }; });
}

}  // namespace weft::tools

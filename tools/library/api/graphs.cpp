// Task graphs and reports of runs: filtered, drawn, compared.
#include <map>
#include <stdexcept>
#include <utility>

#include "engine/json/json.h"
#include "graph/dataflow/dump/graph_drawing.h"
#include "meshing/base/error.h"
#include "tools/common/inputs.h"
#include "tools/common/naming.h"
#include "tools/library/api/require.h"
#include "tools/library/jobs/outputs.h"
#include "tools/library/report/graph_file.h"
#include "tools/library/report/graph_output.h"
#include "tools/library/report/json_file.h"
#include "tools/report/compare.h"
#include "tools/report/report_page.h"
#include "weft/weft.h"

namespace weft {
namespace {

using graph::dataflow::Collapse;
using graph::dataflow::GraphDump;
using Json = nlohmann::ordered_json;

tools::GraphFormat format_named(const std::string& name) {
  const auto found = tools::graph_formats().find(name);
  if (found != tools::graph_formats().end()) return found->second;
  throw OptionError("--format", "'" + name + "' is not one of dot, graphml, json and svg");
}

Collapse collapse_named(const std::string& name) {
  static const std::map<std::string, Collapse> all = {
      {"none", Collapse::none}, {"rounds", Collapse::rounds}, {"subdomains", Collapse::instances}};
  const auto found = all.find(name);
  if (found != all.end()) return found->second;
  throw OptionError("--collapse", "'" + name + "' is not one of none, rounds and subdomains");
}

/// Refuses what would count for nothing.
void check_filter(const GraphFilter& filter, bool as_json) {
  const bool collapsed = filter.collapse != "none";
  require(!filter.plan || !(filter.round || filter.subdomain || filter.critical_path || collapsed), "--plan",
          "is of no run: it has nothing to filter or to merge");
  require(!as_json || !collapsed, "--collapse", "is for drawings: JSON has every task");
}

/// As it is written before a run; an executed graph does not know who may send to whom.
GraphDump plan_of(const GraphDump& graph) {
  return graph.executed() ? graph::dataflow::planned_dump(graph.description, graph.instances, {}) : graph;
}

}  // namespace

std::string graph_text(const std::string& path, const std::string& format, const GraphFilter& filter) {
  const tools::GraphFormat named = format_named(format);
  const Collapse collapse = collapse_named(filter.collapse);
  const bool as_json = named == tools::GraphFormat::json;
  check_filter(filter, as_json);
  const GraphDump all = tools::read_graph(path);
  if (filter.plan)
    return tools::naming(path, [&] {
      return as_json ? tools::graph_text(plan_of(all), named, collapse)
                     : tools::drawing_text(graph::dataflow::drawing_of(all.description), named);
    });
  graph::dataflow::DumpFilter left;
  left.round = filter.round;
  left.instance = filter.subdomain;
  left.critical_path_only = filter.critical_path;
  const GraphDump dump = tools::naming_document(path, [&] { return filtered(all, left); });
  return tools::naming(path, [&] { return tools::graph_text(dump, named, collapse); });
}

std::string graph_format(const std::string& path) {
  const auto format = tools::graph_format(path);
  for (const auto& [name, value] : tools::graph_formats())
    if (format == value) return name;
  return {};
}

void write_report_page(const std::string& profile, const std::string& page) {
  tools::keep_inputs(page, "it", {profile});
  const Json json = tools::read_json(profile);
  tools::write_text(page, tools::naming_document(profile, [&] { return report::report_page(json); }));
}

std::string compare_reports(const std::string& a, const std::string& b, const std::string& page) {
  tools::keep_inputs(page, "it", {a, b});
  const Json first = tools::read_json(a), second = tools::read_json(b);
  const report::Comparison comparison =
      tools::naming_document(a + " or " + b, [&] { return report::compare(a, first, b, second); });
  if (!page.empty()) tools::write_text(page, report::comparison_page(report::comparison_json(comparison)));
  return report::comparison_text(comparison);
}

}  // namespace weft

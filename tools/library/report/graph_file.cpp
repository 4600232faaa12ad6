// Two documents that hold a graph.
#include "tools/library/report/graph_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "graph/dataflow/dump/graph_json.h"
#include "tools/library/report/json_file.h"

namespace weft::tools {
namespace {

/// The graph in a profile, which keeps only what its page shows: without the others a part is no run.
nlohmann::ordered_json whole_graph(nlohmann::ordered_json& profile, const std::string& path) {
  nlohmann::ordered_json graph = std::move(profile["graph"]);
  if (graph.is_null())
    throw meshing::InputError(
        path, "", "contains no graph: none was recorded, or it was too large for a profile; see graph.json");
  const auto left_out =
      naming_document(path, [&] { return profile.value("uses_left_out", std::uint64_t{0}); });
  if (left_out > 0)
    throw meshing::InputError(path, "",
                              fmt::format("its graph lacks {} messages: give graph.json", left_out));
  return graph;
}

}  // namespace

graph::dataflow::GraphDump read_graph(const std::string& path, nlohmann::ordered_json* profile) {
  nlohmann::ordered_json json = read_json(path);
  if (engine::schema_of(json) == "weft-profile-1") {
    nlohmann::ordered_json graph = whole_graph(json, path);
    if (profile != nullptr) *profile = std::move(json);
    json = std::move(graph);
  }
  return naming_document(path, [&] { return graph::dataflow::dump_from_json(json); });
}

}  // namespace weft::tools

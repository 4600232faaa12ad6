// Two documents that hold a graph.
#include "tools/library/report/graph_file.h"

#include <utility>

#include "graph/dataflow/dump/graph_json.h"
#include "tools/library/report/json_file.h"

namespace weft::tools {

graph::dataflow::GraphDump read_graph(const std::string& path) {
  nlohmann::ordered_json json = read_json(path);
  if (engine::schema_of(json) == "weft-profile-1") {
    nlohmann::ordered_json inner = std::move(json["graph"]);
    if (inner.is_null()) throw meshing::InputError(path, "", "contains no graph: the run recorded none");
    json = std::move(inner);
  }
  return naming_document(path, [&] { return graph::dataflow::dump_from_json(json); });
}

}  // namespace weft::tools

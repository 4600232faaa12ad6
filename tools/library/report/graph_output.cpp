#include "tools/library/report/graph_output.h"

#include <fmt/format.h>

#include <filesystem>

#include "engine/json/json.h"
#include "graph/dataflow/dump/graph_files.h"
#include "graph/dataflow/dump/graph_json.h"
#include "meshing/base/error.h"
#include "tools/library/report/graphviz.h"

namespace weft::tools {

using graph::dataflow::Drawing;

const std::map<std::string, GraphFormat>& graph_formats() {
  static const std::map<std::string, GraphFormat> all = {{"dot", GraphFormat::dot},
                                                         {"graphml", GraphFormat::graphml},
                                                         {"json", GraphFormat::json},
                                                         {"svg", GraphFormat::svg}};
  return all;
}

std::optional<GraphFormat> graph_format(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  const auto known = graph_formats().find(extension.empty() ? "" : extension.substr(1));
  if (known == graph_formats().end()) return std::nullopt;
  return known->second;
}

std::string drawing_text(const Drawing& drawing, GraphFormat format) {
  constexpr std::size_t kReadable = 3000;
  if (format == GraphFormat::graphml) return graphml_of(drawing);
  if (format == GraphFormat::dot) return dot_of(drawing);
  if (drawing.vertices.size() > kReadable) {
    throw meshing::InputError("", "",
                              fmt::format("has {} vertices, too many to draw: filter it or use --collapse",
                                          drawing.vertices.size()));
  }
  return svg_of(dot_of(drawing));
}

std::string graph_text(const graph::dataflow::GraphDump& dump, GraphFormat format,
                       graph::dataflow::Collapse collapse) {
  if (format == GraphFormat::json) return graph::dataflow::json_of(dump).dump() + "\n";
  return drawing_text(drawing_of(dump, collapse, dump.description.name), format);
}

}  // namespace weft::tools

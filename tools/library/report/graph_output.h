// Graphs as text in the format that a file's name asks for.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "graph/dataflow/dump/graph_drawing.h"

namespace weft::tools {

enum class GraphFormat { dot, graphml, json, svg };

/// By their names, which are the extensions too.
const std::map<std::string, GraphFormat>& graph_formats();

/// By the extension of a path; empty for another.
std::optional<GraphFormat> graph_format(const std::string& path);

/// A drawing in any format but JSON. Throws InputError (no file name) where Graphviz is needed and fails, and
/// for an SVG of more vertices than can be laid out in minutes.
std::string drawing_text(const graph::dataflow::Drawing& drawing, GraphFormat format);

/// A graph in any format; `collapse` does not touch JSON. Throws as drawing_text().
std::string graph_text(const graph::dataflow::GraphDump& dump, GraphFormat format,
                       graph::dataflow::Collapse collapse);

}  // namespace weft::tools

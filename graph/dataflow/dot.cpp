// Graphviz's language; names go through quoted(), so they may be anything.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "graph/dataflow/graph_files.h"

namespace weft::graph::dataflow {
namespace {

/// Light enough for black text; neighbours in the list differ for the colour-blind too (Okabe and Ito, 2008,
/// lightened).
constexpr std::array<const char*, 10> kFills = {"#b7dcf5", "#f8d999", "#9adbc6", "#f6f0a4", "#9fc6e0",
                                                "#f0b48c", "#e6bfd5", "#d5d5d5", "#c4e39b", "#d9c3a5"};
constexpr const char* kCritical = "#d7191c";

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '\n')
      out += "\\n";
    else
      out += c;
  }
  return out + '"';
}

std::string label_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return quoted(text);
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string vertex_line(const DrawnVertex& vertex) {
  std::string line = quoted(vertex.id) + " [label=" + label_of(vertex.label);
  if (vertex.node) line += std::string(", fillcolor=\"") + kFills[*vertex.node % kFills.size()] + '"';
  if (!vertex.node) line += ", shape=ellipse, margin=" + number(0.02 + 0.12 * vertex.weight);
  if (vertex.critical) line += std::string(", color=\"") + kCritical + "\", penwidth=2.5";
  return line + "];\n";
}

std::string edge_line(const Drawing& drawing, const DrawnEdge& edge) {
  std::string line = quoted(drawing.vertices[edge.from].id) + " -> " + quoted(drawing.vertices[edge.to].id);
  line += " [label=" + quoted(edge.label);
  if (edge.kind == DrawnEdgeKind::remote) line += ", style=dashed";
  if (edge.kind == DrawnEdgeKind::wake || edge.kind == DrawnEdgeKind::order) line += ", style=dotted";
  if (edge.critical) line += std::string(", color=\"") + kCritical + "\", penwidth=2.5";
  return line + "];\n";
}

}  // namespace

std::string dot_of(const Drawing& drawing) {
  std::string text = "digraph " + quoted(drawing.name) + " {\n";
  text += "  graph [rankdir=LR, fontname=\"Helvetica\", fontsize=12, nodesep=0.25, ranksep=0.6];\n";
  text +=
      "  node [shape=box, style=\"rounded,filled\", fillcolor=\"#ffffff\", fontname=\"Helvetica\", "
      "fontsize=11];\n";
  text += "  edge [fontname=\"Helvetica\", fontsize=9, color=\"#555555\"];\n";
  std::vector<std::string> inside(drawing.clusters.size());
  for (const DrawnVertex& vertex : drawing.vertices) {
    if (vertex.cluster)
      inside[*vertex.cluster] += "    " + vertex_line(vertex);
    else
      text += "  " + vertex_line(vertex);
  }
  for (std::size_t c = 0; c < drawing.clusters.size(); ++c) {
    text += "  subgraph cluster_" + std::to_string(c) + " {\n    label=" + quoted(drawing.clusters[c]) +
            "; style=rounded; color=\"#999999\";\n" + inside[c] + "  }\n";
  }
  for (const DrawnEdge& edge : drawing.edges) text += "  " + edge_line(drawing, edge);
  return text + "}\n";
}

}  // namespace weft::graph::dataflow

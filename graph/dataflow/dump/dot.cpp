// Graphviz's language; names go through quoted(), so they may be anything.
#include <algorithm>
#include <array>
#include <string_view>

#include "engine/base/text.h"
#include "graph/dataflow/dump/graph_files.h"

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

/// How a drawing is laid out. Graphviz's layers suit what has a direction. A network of many subdomains has
/// none, and layers of it take hours: there springs pull neighbours together. They know no clusters, so
/// colours tell these. Where there are many edges their labels, which would cover each other, become
/// tooltips.
struct Layout {
  bool springs = false;
  bool arrows = true;
  bool edge_labels = true;
};

Layout layout_of(const Drawing& drawing) {
  constexpr std::size_t kMostInLayers = 24, kMostLabels = 40;
  constexpr std::size_t kMostLabelsInLayers = 400;  // 4,000 take 2 s without, minutes with them
  if (!drawing.network) return {false, true, drawing.edges.size() <= kMostLabelsInLayers};
  return {drawing.vertices.size() > kMostInLayers, false, drawing.edges.size() <= kMostLabels};
}

std::string fill(std::size_t i) { return std::string(", fillcolor=\"") + kFills[i % kFills.size()] + '"'; }

std::string vertex_line(const Drawing& drawing, const DrawnVertex& vertex, const Layout& layout) {
  std::vector<std::string> label = vertex.label;
  const bool by_cluster = layout.springs && vertex.cluster;
  if (by_cluster && drawing.clusters.size() > 1) label.push_back(drawing.clusters[*vertex.cluster]);
  std::string line = quoted(vertex.id) + " [label=" + label_of(label);
  if (vertex.node) line += fill(*vertex.node);
  if (by_cluster) line += fill(*vertex.cluster);
  if (!vertex.node) line += ", shape=ellipse, margin=" + engine::significant(0.02 + 0.12 * vertex.weight, 3);
  if (vertex.critical) line += std::string(", color=\"") + kCritical + "\", penwidth=2.5";
  return line + "];\n";
}

std::string edge_line(const Drawing& drawing, const DrawnEdge& edge, const Layout& layout) {
  std::string line = quoted(drawing.vertices[edge.from].id) + " -> " + quoted(drawing.vertices[edge.to].id);
  line += layout.edge_labels ? " [label=" : " [tooltip=";
  line += quoted(edge.label);
  if (!layout.arrows)
    line += ", dir=none";
  else if (edge.kind == DrawnEdgeKind::remote)
    line += ", style=dashed";
  if (edge.kind == DrawnEdgeKind::wake || edge.kind == DrawnEdgeKind::order) line += ", style=dotted";
  if (edge.critical) line += std::string(", color=\"") + kCritical + "\", penwidth=2.5";
  return line + "];\n";
}

std::string clusters_text(const Drawing& drawing, const Layout& layout) {
  std::vector<std::string> inside(drawing.clusters.size());
  std::string text;
  for (const DrawnVertex& vertex : drawing.vertices) {
    if (vertex.cluster && !layout.springs)
      inside[*vertex.cluster] += "    " + vertex_line(drawing, vertex, layout);
    else
      text += "  " + vertex_line(drawing, vertex, layout);
  }
  for (std::size_t c = 0; c < inside.size() && !layout.springs; ++c) {
    text += "  subgraph cluster_" + std::to_string(c) + " {\n    label=" + quoted(drawing.clusters[c]) +
            "; style=rounded; color=\"#999999\";\n" + inside[c] + "  }\n";
  }
  return text;
}

}  // namespace

std::string dot_of(const Drawing& any_drawing) {
  const Drawing drawing = any_drawing.network ? joined_edges(any_drawing) : any_drawing;
  const Layout layout = layout_of(drawing);
  std::string text = "digraph " + quoted(drawing.name) + " {\n  graph [fontname=\"Helvetica\", fontsize=12, ";
  text += layout.springs ? "layout=sfdp, overlap=prism, splines=line, outputorder=edgesfirst];\n"
                         : "rankdir=LR, nodesep=0.25, ranksep=0.6];\n";
  text +=
      "  node [shape=box, style=\"rounded,filled\", fillcolor=\"#ffffff\", fontname=\"Helvetica\", "
      "fontsize=11];\n";
  text += "  edge [fontname=\"Helvetica\", fontsize=9, color=\"#555555\"];\n";
  text += clusters_text(drawing, layout);
  for (const DrawnEdge& edge : drawing.edges) text += "  " + edge_line(drawing, edge, layout);
  return text + "}\n";
}

}  // namespace weft::graph::dataflow

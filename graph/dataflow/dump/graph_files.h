// Drawings of graphs in the formats of graph tools.
#pragma once

#include <string>

#include "graph/dataflow/dump/graph_drawing.h"

namespace weft::graph::dataflow {

/// For Graphviz: vertices coloured by their node, clusters boxed, what crosses ranks dashed, the critical
/// path red.
std::string dot_of(const Drawing& drawing);

/// GraphML (graphml.graphdrawing.org), for yEd, Gephi, NetworkX: all attributes typed, the label and the
/// cluster among them.
std::string graphml_of(const Drawing& drawing);

}  // namespace weft::graph::dataflow

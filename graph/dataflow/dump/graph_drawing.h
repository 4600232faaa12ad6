// What a picture of a graph shows: vertices, edges and clusters, whatever the format.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "graph/dataflow/dump/graph_dump.h"

namespace weft::graph::dataflow {

/// What a drawing says of a vertex or an edge beside its label.
using Attribute = std::pair<std::string, std::variant<std::int64_t, double, std::string>>;

struct DrawnVertex {
  std::string id;                      ///< unique in the drawing
  std::vector<std::string> label;      ///< lines
  std::optional<std::uint32_t> node;   ///< NodeIndex, for the colour; none: the vertex stands for several
  std::optional<std::size_t> cluster;  ///< index in Drawing::clusters
  bool critical = false;
  double weight = 0;                  ///< 0 to 1: share of the most seconds of any vertex
  std::vector<Attribute> attributes;  ///< the same names for all vertices of a drawing
};

enum class DrawnEdgeKind : std::uint8_t { local, remote, wake, order };  ///< order: follows in the instance
const char* name_of(DrawnEdgeKind kind);

struct DrawnEdge {
  std::size_t from = 0;  ///< index of a vertex
  std::size_t to = 0;
  DrawnEdgeKind kind = DrawnEdgeKind::local;
  std::string label;
  bool critical = false;
  std::vector<Attribute> attributes;  ///< the same names for all edges of a drawing
};

struct Drawing {
  std::string name;
  std::vector<std::string> clusters;  ///< their titles
  std::vector<DrawnVertex> vertices;
  std::vector<DrawnEdge> edges;
  bool network = false;  ///< vertices are instances
};

/// A network for the eye: one edge without direction between two instances, for all that they exchange, its
/// label the sum of bytes. Subdomains exchange four values a round in either direction.
Drawing joined_edges(const Drawing& network);

/// What becomes one vertex.
enum class Collapse : std::uint8_t {
  none,       ///< each run; of a planned graph, each node of each instance
  rounds,     ///< all runs of a node in a round; of a planned graph, each node
  instances,  ///< each instance with all its runs
};

/// Clusters are ranks; collapsed by rounds, they are rounds. `instance_word`: what users call an instance.
Drawing drawing_of(const GraphDump& dump, Collapse collapse, const std::string& instance_word);

/// The blueprint alone.
Drawing drawing_of(const GraphDescription& description);

}  // namespace weft::graph::dataflow

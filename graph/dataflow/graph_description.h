// A task graph as plain data: what dumps of planned and executed graphs are made from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace weft::graph::dataflow {

/// Number of a node in its graph, in the order of declaration.
using NodeIndex = std::uint32_t;
/// Number of an edge in its graph, in the order of declaration.
using EdgeIndex = std::uint32_t;

enum class NodeKind : std::uint8_t {
  start,     ///< runs when the program says so (start()), or a local predecessor passes a value on
  interior,  ///< runs when a local predecessor passes a value on
  event,     ///< runs once values from all instances of a set have arrived
  wake,      ///< runs at the first arrival of a round that its event has not declared
};
const char* name_of(NodeKind kind);

enum class EdgeKind : std::uint8_t {
  local,   ///< from node to node of one instance
  remote,  ///< from a node to an event of other instances (or the same), wherever they are
  wake,    ///< from an event to the node that its first undeclared arrival runs
};
const char* name_of(EdgeKind kind);

/// In which round the successor on a local edge runs.
enum class RoundStep : std::uint8_t { same, next };

struct NodeDescription {
  std::string name;
  NodeKind kind = NodeKind::interior;
};

struct EdgeDescription {
  std::string name;  ///< "propose -> gather"
  EdgeKind kind = EdgeKind::local;
  NodeIndex from = 0;
  NodeIndex to = 0;
  RoundStep step = RoundStep::same;  ///< of local edges
  std::string value_type;            ///< C++ name of what travels along it
};

/// The graph that every instance of a blueprint has.
struct GraphDescription {
  std::string name;
  std::vector<NodeDescription> nodes;  ///< by NodeIndex
  std::vector<EdgeDescription> edges;  ///< by EdgeIndex
};

}  // namespace weft::graph::dataflow

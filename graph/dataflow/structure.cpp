// The rules of building: each node once, each edge once, no circles.
#include "graph/dataflow/structure.h"

#include <algorithm>
#include <stdexcept>

#include "engine/base/text.h"

namespace weft::graph::dataflow {

const char* name_of(NodeKind kind) {
  switch (kind) {
    case NodeKind::start:
      return "start";
    case NodeKind::interior:
      return "interior";
    case NodeKind::event:
      return "event";
    case NodeKind::wake:
      return "wake";
  }
  return "";
}

const char* name_of(EdgeKind kind) {
  switch (kind) {
    case EdgeKind::local:
      return "local";
    case EdgeKind::remote:
      return "remote";
    case EdgeKind::wake:
      return "wake";
  }
  return "";
}

namespace {

template <class... Parts>
[[noreturn]] void refuse(const Structure& graph, const Parts&... parts) {
  throw std::logic_error(engine::text("graph ", graph.name(), ": ", parts...));
}

}  // namespace

NodeIndex Structure::add_node(StructureNode node) {
  for (const StructureNode& other : nodes_) {
    if (other.name == node.name) refuse(*this, "there are two nodes ", node.name);
    if (other.body == node.body) {
      refuse(*this, "the nodes ", other.name, " and ", node.name, " have the same body");
    }
  }
  description_.nodes.push_back({node.name, node.kind});
  nodes_.push_back(std::move(node));
  return static_cast<NodeIndex>(nodes_.size() - 1);
}

EdgeIndex Structure::add_edge(EdgeKind kind, NodeIndex from, NodeIndex to, RoundStep step,
                              std::string value_type) {
  if (from >= nodes_.size() || to >= nodes_.size()) refuse(*this, "an edge joins nodes of another graph");
  std::string name = engine::text(nodes_[from].name, " -> ", nodes_[to].name);
  for (const EdgeDescription& other : description_.edges) {
    if (other.kind == kind && other.from == from && other.to == to) {
      refuse(*this, "the ", name_of(kind), " edge ", name, " is declared twice");
    }
  }
  description_.edges.push_back({std::move(name), kind, from, to, step, std::move(value_type)});
  return static_cast<EdgeIndex>(description_.edges.size() - 1);
}

void Structure::add_local(NodeIndex from, NodeIndex to, RoundStep step, bool copyable,
                          std::string value_type) {
  const EdgeIndex edge = add_edge(EdgeKind::local, from, to, step, std::move(value_type));
  const std::string& name = description_.edges[edge].name;
  if (nodes_[to].kind == NodeKind::wake) {
    refuse(*this, "the local edge ", name, " ends at a node that only an arrival may run");
  }
  if (reaches(to, from)) refuse(*this, "the local edge ", name, " closes a circle of local edges");
  if (!copyable && !nodes_[from].local_edges.empty()) {
    refuse(*this, "the local edge ", name, " is the second from ", nodes_[from].name,
           ", whose value cannot be copied");
  }
  nodes_[from].local_edges.push_back(edge);
}

void Structure::add_remote(NodeIndex from, NodeIndex to, std::string value_type) {
  const EdgeIndex edge = add_edge(EdgeKind::remote, from, to, RoundStep::same, std::move(value_type));
  nodes_[from].remote_edges.push_back(edge);
}

void Structure::add_wake(NodeIndex event, NodeIndex wake) {
  if (event < nodes_.size() && nodes_[event].wake) {
    refuse(*this, "the event ", nodes_[event].name, " wakes two nodes, ", nodes_[*nodes_[event].wake].name,
           " and ", nodes_[wake].name);
  }
  add_edge(EdgeKind::wake, event, wake, RoundStep::same, "round");
  nodes_[event].wake = wake;
}

/// Whether there is a way of local edges.
bool Structure::reaches(NodeIndex from, NodeIndex to) const {
  if (from == to) return true;
  const auto& edges = nodes_[from].local_edges;
  return std::any_of(edges.begin(), edges.end(), [&](EdgeIndex e) { return reaches(edge(e).to, to); });
}

NodeIndex Structure::node_of(const void* body) const {
  const auto found =
      std::find_if(nodes_.begin(), nodes_.end(), [&](const StructureNode& n) { return n.body == body; });
  if (found == nodes_.end()) refuse(*this, "a body is used that is no node of this graph");
  return static_cast<NodeIndex>(found - nodes_.begin());
}

EdgeIndex Structure::remote_edge(NodeIndex from, NodeIndex event) const {
  for (const EdgeIndex e : nodes_[from].remote_edges) {
    if (edge(e).to == event) return e;
  }
  refuse(*this, "the node ", nodes_[from].name, " sends to the event ", nodes_[event].name,
         ", but no remote edge ", nodes_[from].name, " -> ", nodes_[event].name, " is declared");
}

}  // namespace weft::graph::dataflow

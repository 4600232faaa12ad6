// A blueprint without the types of its values: nodes that can be called, edges, and the rules they keep.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/schedule/context.h"
#include "graph/dataflow/graph_description.h"

namespace weft::graph::dataflow {

class NodeContext;

/// The values that have arrived at an event, packed, in the order in which their senders were declared.
using PackedArrivals = std::vector<std::pair<engine::ObjectId, engine::Payload>>;

/// What a body passes on.
struct Passed {
  std::shared_ptr<void> value;  ///< null: nothing
  const void* type = nullptr;   ///< detail::type_key of the alternative that a std::variant holds; else null
};

/// What passes a local edge. The value is of the type that the blueprint has checked; a start's, a wake's and
/// an event's first one come from the instance.
struct Token {
  std::shared_ptr<void> value;
  std::uint64_t round = 0;
  const void* type = nullptr;  ///< as Passed::type: only nodes that take it run
  bool shared = false;         ///< several nodes read the value
};

/// A node as the instance sees it.
struct StructureNode {
  /// Calls the body. `consume`: nobody else reads the input.
  using Run = Passed (*)(void* state, NodeContext& context, void* input, bool consume);
  /// Sends a value to the event of another instance.
  using Send = void (*)(engine::Context& context, engine::ObjectId target, std::uint64_t round,
                        engine::Payload value);
  /// Makes this instance run the event, which is complete.
  using Fire = void (*)(engine::Context& context, std::uint64_t round, engine::Seconds seconds);

  std::string name;
  NodeKind kind = NodeKind::interior;
  const void* body = nullptr;   ///< detail::body_key
  const void* input = nullptr;  ///< detail::type_key; null: takes anything
  Run run = nullptr;
  Send send = nullptr;            ///< of events
  Fire fire = nullptr;            ///< of events
  std::optional<NodeIndex> wake;  ///< of events

  std::vector<EdgeIndex> local_edges;   ///< from here
  std::vector<EdgeIndex> remote_edges;  ///< from here
};

/// Built once, constant afterwards. Misuse throws std::logic_error that names graph, nodes and edge.
class Structure {
 public:
  explicit Structure(std::string name) { description_.name = std::move(name); }

  /// Each name and each body once.
  NodeIndex add_node(StructureNode node);

  /// At most one edge of a kind from node to node; no circle of local edges; no local edge to an event.
  void add_local(NodeIndex from, NodeIndex to, RoundStep step, bool copyable, std::string value_type);
  void add_remote(NodeIndex from, NodeIndex to, std::string value_type);
  void add_wake(NodeIndex event, NodeIndex wake);

  const GraphDescription& description() const { return description_; }
  const std::string& name() const { return description_.name; }
  const std::vector<StructureNode>& nodes() const { return nodes_; }
  const EdgeDescription& edge(EdgeIndex edge) const { return description_.edges[edge]; }

  /// The node with this body.
  NodeIndex node_of(const void* body) const;
  /// Whether a value of Passed::type `type` is for the node.
  bool takes(NodeIndex node, const void* type) const {
    const void* input = nodes_[node].input;
    return type == nullptr || input == nullptr || type == input;
  }
  /// The edge along which `from` may send to `event`.
  EdgeIndex remote_edge(NodeIndex from, NodeIndex event) const;

 private:
  EdgeIndex add_edge(EdgeKind kind, NodeIndex from, NodeIndex to, RoundStep step, std::string value_type);
  bool reaches(NodeIndex from, NodeIndex to) const;

  GraphDescription description_;
  std::vector<StructureNode> nodes_;
};

}  // namespace weft::graph::dataflow

// Nodes and edges of TBB's for nodes and edges of a structure.
#include "graph/dataflow/flow_graph.h"

#include <oneapi/tbb/flow_graph.h>

#include <exception>
#include <tuple>
#include <utility>
#include <vector>

namespace weft::graph::dataflow {

struct FlowGraph::Implementation {
  /// Ports: values for the same round, and for the next. A node is run where its input is put only if it
  /// cannot throw.
  using TbbNode =
      tbb::flow::multifunction_node<Token, std::tuple<Token, Token>, tbb::flow::queueing_lightweight>;

  Implementation(const Structure& graph_structure, Run run_node)
      : structure(graph_structure), run(std::move(run_node)) {
    for (NodeIndex i = 0; i < structure.nodes().size(); ++i) {
      nodes.push_back(std::make_unique<TbbNode>(
          graph, tbb::flow::unlimited,
          [this, i](const Token& input, TbbNode::output_ports_type& ports) noexcept {
            step(i, input, ports);
          }));
    }
    for (const EdgeDescription& edge : structure.description().edges) {
      if (edge.kind != EdgeKind::local) continue;
      if (edge.step == RoundStep::same) {
        tbb::flow::make_edge(tbb::flow::output_port<0>(*nodes[edge.from]), *nodes[edge.to]);
      } else {
        tbb::flow::make_edge(tbb::flow::output_port<1>(*nodes[edge.from]), *nodes[edge.to]);
      }
    }
  }

  void step(NodeIndex node, const Token& input, TbbNode::output_ports_type& ports) noexcept {
    if (error || !structure.takes(node, input.type)) return;
    Token output;
    try {
      Passed passed = run(node, input);
      output.value = std::move(passed.value);
      output.type = passed.type;
    } catch (...) {
      error = std::current_exception();
      return;
    }
    if (output.value == nullptr) return;
    output.round = input.round;
    output.shared = structure.nodes()[node].local_edges.size() > 1;
    std::get<0>(ports).try_put(output);
    ++output.round;
    std::get<1>(ports).try_put(output);
  }

  const Structure& structure;
  tbb::flow::graph graph;
  Run run;
  std::vector<std::unique_ptr<TbbNode>> nodes;
  std::exception_ptr error;
};

FlowGraph::FlowGraph(const Structure& structure, Run run)
    : implementation_(std::make_unique<Implementation>(structure, std::move(run))) {}
FlowGraph::~FlowGraph() = default;

void FlowGraph::run(NodeIndex node, Token input) {
  implementation_->nodes[node]->try_put(input);
  implementation_->graph.wait_for_all();
  if (implementation_->error) std::rethrow_exception(std::exchange(implementation_->error, nullptr));
}

}  // namespace weft::graph::dataflow

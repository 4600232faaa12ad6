// The oneTBB flow graph of one instance; the door to TBB's flow graph.
#pragma once

#include <functional>
#include <memory>

#include "graph/dataflow/structure.h"

namespace weft::graph::dataflow {

/// A tbb::flow::graph with a node for each node of a structure and TBB's edges for the local ones. The nodes
/// are lightweight: each runs on the thread that put its input, so an instance's bodies, which share its
/// state, run one at a time and in a fixed order: a node's successors in the order in which their edges were
/// declared (those of the same round first), each with all that follows from it before the next.
class FlowGraph {
 public:
  /// Runs a node on its input and returns what it passes on. What it throws ends the graph's run.
  using Run = std::function<Passed(NodeIndex node, const Token& input)>;

  /// `structure` must outlive it.
  FlowGraph(const Structure& structure, Run run);
  ~FlowGraph();

  /// Puts `input` into `node` and returns when nothing runs any more. Throws what the first failing body
  /// threw; no body runs after that one.
  void run(NodeIndex node, Token input);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::graph::dataflow

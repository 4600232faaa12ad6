// Events, runs of the flow graph, and their record.
#include "graph/dataflow/instance_core.h"

#include <exception>
#include <stdexcept>
#include <utility>

#include "engine/base/text.h"
#include "engine/trace/processor_time.h"
#include "engine/trace/trace.h"
#include "graph/dataflow/node_context.h"

namespace weft::graph::dataflow {
namespace {

/// Runs `step` on the engine's table of events, whose errors know neither graph nor node.
template <class Step>
auto naming(const Structure& graph, NodeIndex event, const Step& step) {
  try {
    return step();
  } catch (const std::logic_error& error) {
    throw std::logic_error(
        engine::text("graph ", graph.name(), ": event ", graph.nodes()[event].name, ": ", error.what()));
  }
}

std::uint64_t bytes_of(const PackedArrivals& arrivals) {
  std::uint64_t bytes = 0;
  for (const auto& [from, payload] : arrivals) bytes += payload.size();
  return bytes;
}

}  // namespace

// --- Messages

void InstanceCore::run(engine::Context& context, NodeIndex node, Token input) {
  context_ = &context;
  FlowGraph flow(structure_, [this](NodeIndex n, const Token& token) { return run_node(n, token); });
  flow.run(node, std::move(input));
}

void InstanceCore::arrive(engine::Context& context, const void* event, engine::ObjectId from,
                          std::uint64_t round, engine::Payload value) {
  const NodeIndex node = structure_.node_of(event);
  const engine::EventKey key{node, round};
  const bool first_undeclared = known_.insert(key).second;
  auto fired = naming(structure_, node, [&] {
    if (complete_.contains(key)) {
      throw std::logic_error(
          engine::text("object ", from, " signals round ", round, " though all its values have come"));
    }
    return events_.arrive(key, from, std::move(value));
  });
  if (fired) return complete(context, node, std::move(*fired));
  const auto& wake = structure_.nodes()[node].wake;
  if (first_undeclared && wake) run(context, *wake, {std::make_shared<std::uint64_t>(round), round});
}

/// The event runs by a message of its own: so the balancer sees what it will cost, and may move the instance
/// before it.
void InstanceCore::complete(engine::Context& context, NodeIndex event, engine::FiredEvent fired) {
  known_.erase(fired.key);
  complete_.emplace(fired.key, std::move(fired.arrivals));
  structure_.nodes()[event].fire(context, fired.key.round, engine::Seconds{fired.expected});
}

void InstanceCore::fire(engine::Context& context, const void* event, std::uint64_t round) {
  const NodeIndex node = structure_.node_of(event);
  auto found = complete_.extract({node, round});
  run(context, node, {std::make_shared<PackedArrivals>(std::move(found.mapped())), round});
}

// --- The running node

Passed InstanceCore::run_node(NodeIndex node, const Token& input) {
  if (recording_ == Recording::on) record_run(node, input);
  const engine::TimePoint begin = recording_ == Recording::on ? engine::processor_time() : 0;
  Passed output = call_body(node, input);
  if (recording_ == Recording::on) {
    log_.runs.back().end = engine::now();
    log_.count(kProcessorSeconds, 1e-9 * static_cast<double>(engine::processor_time() - begin));
    if (output.value != nullptr) record_local_uses(node, output.type, input.round);
  }
  return output;
}

Passed InstanceCore::call_body(NodeIndex node, const Token& input) {
  NodeContext context(*context_, *this, node, input.round);
  std::string what;
  try {
    return structure_.nodes()[node].run(state_, context, input.value.get(), !input.shared);
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
    what = "an exception of unknown type";
  }
  throw std::runtime_error(engine::text("node ", structure_.nodes()[node].name, " of graph ",
                                        structure_.name(), ", instance ", context_->self(), ", round ",
                                        input.round, ": ", what));
}

void InstanceCore::send(engine::Context& context, NodeIndex from, const void* event, engine::ObjectId target,
                        std::uint64_t round, engine::Payload value) {
  const NodeIndex to = structure_.node_of(event);
  const EdgeIndex edge = structure_.remote_edge(from, to);
  if (recording_ == Recording::on) {
    log_.uses.push_back({edge, context.self(), target, round, value.size(), context.rank(), engine::now()});
  }
  structure_.nodes()[to].send(context, target, round, std::move(value));
}

void InstanceCore::declare(engine::Context& context, const void* event, std::uint64_t round,
                           std::vector<engine::ObjectId> from, engine::Seconds seconds) {
  const NodeIndex node = structure_.node_of(event);
  const engine::EventKey key{node, round};
  known_.insert(key);
  auto fired = naming(structure_, node, [&] {
    if (complete_.contains(key)) {
      throw std::logic_error(engine::text("it is declared again before it has run in round ", round));
    }
    return events_.declare(key, std::move(from), seconds.value);
  });
  if (fired) complete(context, node, std::move(*fired));
}

// --- Record

void InstanceCore::record_run(NodeIndex node, const Token& input) {
  NodeRun run;
  run.node = node;
  run.instance = context_->self();
  run.round = input.round;
  run.rank = context_->rank();
  if (structure_.nodes()[node].kind == NodeKind::event) {
    run.bytes_received = bytes_of(*static_cast<const PackedArrivals*>(input.value.get()));
  }
  run.first_counter = static_cast<std::uint32_t>(log_.counters.size());
  run.begin = engine::now();
  log_.runs.push_back(run);
}

void InstanceCore::record_local_uses(NodeIndex node, const void* type, std::uint64_t round) {
  for (const EdgeIndex edge : structure_.nodes()[node].local_edges) {
    if (!structure_.takes(structure_.edge(edge).to, type)) continue;
    const std::uint64_t target = round + (structure_.edge(edge).step == RoundStep::next ? 1 : 0);
    log_.uses.push_back(
        {edge, context_->self(), context_->self(), target, 0, context_->rank(), log_.runs.back().end});
  }
}

void InstanceCore::count(std::string_view name, double amount) {
  if (recording_ == Recording::on) log_.count(name, amount);
}

std::vector<engine::NamedWait> InstanceCore::waits() const {
  std::vector<engine::NamedWait> all;
  for (const engine::EventWait& wait : events_.waits())
    all.push_back({structure_.nodes()[wait.key.method].name, wait});
  return all;
}

std::vector<std::string> InstanceCore::incomplete() const {
  std::vector<std::string> lines;
  for (const auto& [event, wait] : waits()) {
    std::string line = engine::text(event, " in round ", wait.key.round,
                                    wait.declared ? " waits for" : " is not declared for the values of");
    for (const engine::ObjectId id : wait.declared ? wait.missing : wait.arrived)
      line += engine::text(' ', id);
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace weft::graph::dataflow

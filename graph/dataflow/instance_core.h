// An instance of a blueprint without the type of its state: its events, its flow graph, its log.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/objects/event.h"
#include "engine/schedule/context.h"
#include "graph/dataflow/execution_log.h"
#include "graph/dataflow/flow_graph.h"
#include "graph/dataflow/structure.h"

namespace weft::graph::dataflow {

/// What Instance<State> does for any State. Events and log travel with it; the flow graph is made for each
/// run, because destroying one enters the arena of the workers: a thread that is none of them, as the one
/// that sends an instance away, would wait until a worker is free.
class InstanceCore {
 public:
  InstanceCore(const Structure& structure, void* state, Recording recording)
      : structure_(structure), state_(state), recording_(recording) {}
  InstanceCore(const InstanceCore&) = delete;
  InstanceCore& operator=(const InstanceCore&) = delete;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(recording_, events_, known_, complete_, log_);
  }

  // For the engine's messages.

  /// Runs `node` and all that follows from it locally, in a flow graph.
  void run(engine::Context& context, NodeIndex node, Token input);
  /// A value for an event has come.
  void arrive(engine::Context& context, const void* event, engine::ObjectId from, std::uint64_t round,
              engine::Payload value);
  /// Runs an event that is complete.
  void fire(engine::Context& context, const void* event, std::uint64_t round);

  // For the running node's context.

  void send(engine::Context& context, NodeIndex from, const void* event, engine::ObjectId target,
            std::uint64_t round, engine::Payload value);
  void declare(engine::Context& context, const void* event, std::uint64_t round,
               std::vector<engine::ObjectId> from, engine::Seconds seconds);
  void count(std::string_view name, double amount);

  // For the program, between runs.

  NodeIndex node_of(const void* body) const { return structure_.node_of(body); }
  const ExecutionLog& log() const { return log_; }
  /// What ran before a checkpoint has times and ranks of another run.
  void forget_log() { log_ = {}; }
  /// The events that wait, or for which values have come before they were declared.
  std::vector<engine::NamedWait> waits() const;
  /// One line for each event that lacks arrivals, "gather in round 4 waits for 0.2 1.1", or has some without
  /// being declared, "gather in round 5 is not declared for the values of 0.2".
  std::vector<std::string> incomplete() const;

 private:
  Passed run_node(NodeIndex node, const Token& input);
  Passed call_body(NodeIndex node, const Token& input);
  void record_run(NodeIndex node, const Token& input);
  void record_local_uses(NodeIndex node, const void* type, std::uint64_t round);
  void complete(engine::Context& context, NodeIndex event, engine::FiredEvent fired);

  const Structure& structure_;
  void* state_;
  Recording recording_;
  engine::EventTable events_;                            ///< EventKey::method is the event's NodeIndex
  std::set<engine::EventKey> known_;                     ///< declared, or a value has come
  std::map<engine::EventKey, PackedArrivals> complete_;  ///< events that fire soon
  ExecutionLog log_;
  engine::Context* context_ = nullptr;  ///< while the flow graph runs
};

}  // namespace weft::graph::dataflow

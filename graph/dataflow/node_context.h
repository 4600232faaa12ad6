// What a node's body can do: its instance and the network as seen from inside.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/serialize.h"
#include "engine/schedule/context.h"
#include "graph/dataflow/body_traits.h"
#include "graph/dataflow/graph_description.h"

namespace weft::graph::dataflow {

class InstanceCore;

/// Given to every body, for the time of its run, and to be used by the thread that runs it; only
/// stop_requested() may be called by others. Misuse throws std::logic_error that names graph, node and edge.
class NodeContext {
 public:
  NodeContext(engine::Context& engine, InstanceCore& instance, NodeIndex node, std::uint64_t round)
      : engine_(engine), instance_(instance), node_(node), round_(round) {}
  NodeContext(const NodeContext&) = delete;
  NodeContext& operator=(const NodeContext&) = delete;

  engine::Rank rank() const { return engine_.rank(); }
  int ranks() const { return engine_.ranks(); }

  /// This instance: `Ref<State>{context.self()}`.
  engine::ObjectId self() const { return engine_.self(); }

  /// The round of this run: that of the event which set the graph going, or of start(), plus one for each
  /// local edge with RoundStep::next since.
  std::uint64_t round() const { return round_; }

  /// Sends `value` to an event of another instance (or of this one) in `round`, along the remote edge from
  /// the running node, which must have been declared. The value is consumed. Once a round for each target
  /// and event.
  template <auto Event, class Value = Nothing>
  void send(Ref<typename detail::EventBodyTraits<decltype(Event)>::State> target, std::uint64_t round,
            Value value = {}) {
    static_assert(std::is_same_v<Value, typename detail::EventBodyTraits<decltype(Event)>::Value>,
                  "the value sent is not of the type that the event receives: std::vector<Arrival<Value>>");
    engine::Packer packer(true);
    packer(value);
    send_packed(&detail::body_key<Event>, target.id, round, packer.take());
  }

  /// This instance's Event is to run in `round` once each of `from` has sent it a value; their arrivals are
  /// given to it in this order. None: it runs at once (but not inside this body). The set may differ from
  /// round to round, and values may come before this. `seconds`: what Event and the nodes after it will
  /// take, for the balancer.
  template <auto Event>
  void expect(std::uint64_t round,
              const std::vector<Ref<typename detail::EventBodyTraits<decltype(Event)>::State>>& from,
              engine::Seconds seconds = {}) {
    std::vector<engine::ObjectId> ids;
    ids.reserve(from.size());
    for (const auto& instance : from) ids.push_back(instance.id);
    declare(&detail::body_key<Event>, round, std::move(ids), seconds);
  }

  /// Adds to a counter of this run in the execution log: "tets received", 120. Does nothing when the
  /// instance keeps none.
  void count(std::string_view name, double amount);

  /// The run has failed or was interrupted: a long body should return soon.
  bool stop_requested() const { return engine_.stop_requested(); }
  /// The same as a flag, for what is to look at it often.
  const std::atomic<bool>& stop_flag() const { return engine_.stop_flag(); }

  /// To create and call mobile objects of other types.
  engine::Context& engine() { return engine_; }

 private:
  void send_packed(const void* event, engine::ObjectId target, std::uint64_t round, engine::Payload value);
  void declare(const void* event, std::uint64_t round, std::vector<engine::ObjectId> from,
               engine::Seconds seconds);

  engine::Context& engine_;
  InstanceCore& instance_;
  NodeIndex node_;
  std::uint64_t round_;
};

}  // namespace weft::graph::dataflow

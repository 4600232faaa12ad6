// An instance of a blueprint: a mobile object of the engine that owns a state and runs its graph.
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/base/text.h"
#include "engine/run/runtime.h"
#include "graph/dataflow/body_traits.h"
#include "graph/dataflow/instance_core.h"
#include "graph/dataflow/node_context.h"

namespace weft::graph::dataflow {

/// The graph of State's instances: what State::blueprint() returns, made at the first call. The same for all
/// ranks of a process.
template <class State>
const Structure& structure_of();

/// The mobile object; programs go by Ref<State> and the functions below. `State`: movable, with serialize(),
/// a default constructor and `static Blueprint<State> blueprint()`.
template <class State>
class Instance {
 public:
  Instance() : Instance(State{}, Recording::off) {}
  Instance(State state, Recording recording)
      : state_(std::move(state)), core_(structure_of<State>(), &state_, recording) {}
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(state_, core_);
  }

  /// For engine::Runtime::request_state(): what the state says of itself, if it has `std::string describe()
  /// const`, and the events.
  engine::ObjectState describe() const {
    engine::ObjectState described{{}, core_.waits()};
    if constexpr (requires { state_.describe(); }) described.what = state_.describe();
    return described;
  }

  State& state() { return state_; }
  const InstanceCore& core() const { return core_; }
  InstanceCore& core() { return core_; }

  // The engine's methods; registered by register_blueprint().

  template <auto Body>
  void start(engine::Context& context, std::uint64_t round,
             typename detail::BodyTraits<decltype(Body)>::Input value) {
    using Input = typename detail::BodyTraits<decltype(Body)>::Input;
    core_.run(context, core_.node_of(&detail::body_key<Body>),
              {std::make_shared<Input>(std::move(value)), round});
  }
  template <auto Event>
  void arrive(engine::Context& context, engine::ObjectId from, std::uint64_t round, engine::Payload value) {
    core_.arrive(context, &detail::body_key<Event>, from, round, std::move(value));
  }
  template <auto Event>
  void fire(engine::Context& context, std::uint64_t round) {
    core_.fire(context, &detail::body_key<Event>, round);
  }

 private:
  State state_;
  InstanceCore core_;
};

/// Makes an instance on this rank.
template <class State>
Ref<State> create(engine::Context& context, State state = {}, Recording recording = Recording::off) {
  return context.create<Instance<State>>(std::move(state), recording);
}

/// Runs the instance's start node Body in `round`, some time after this; what follows from it locally runs
/// after it, in the same handler. The value is consumed. `seconds`: what all that will take, for the
/// balancer.
template <auto Body>
void start(engine::Context& context, Ref<typename detail::BodyTraits<decltype(Body)>::State> instance,
           std::uint64_t round = 0, typename detail::BodyTraits<decltype(Body)>::Input value = {},
           engine::Seconds seconds = {}) {
  using State = typename detail::BodyTraits<decltype(Body)>::State;
  context.invoke_expecting<&Instance<State>::template start<Body>>(seconds, instance, round,
                                                                   std::move(value));
}

/// Visits the states of the instances that are here now, in the order of their ids; not during a run.
template <class State>
void visit(engine::Runtime& runtime, const std::function<void(Ref<State>, State&)>& function) {
  runtime.visit<Instance<State>>(
      [&](Ref<State> ref, Instance<State>& instance) { function(ref, instance.state()); });
}

/// Instances that were restored begin their logs anew; not during a run.
template <class State>
void forget_logs(engine::Runtime& runtime) {
  runtime.visit<Instance<State>>([](Ref<State>, Instance<State>& instance) { instance.core().forget_log(); });
}

/// The logs of the instances that are here now; not during a run.
template <class State>
ExecutionLog log_of(engine::Runtime& runtime) {
  ExecutionLog log;
  runtime.visit<Instance<State>>(
      [&](Ref<State>, Instance<State>& instance) { log.append(ExecutionLog(instance.core().log())); });
  return log;
}

/// The events of the instances that are here now which are declared but lack arrivals, or have some but are
/// not declared, one line each: "object 3.1: gather in round 4 waits for 0.2 1.1", "object 3.1: gather in
/// round 5 is not declared for the values of 0.2". After a run that should have finished its protocol, any
/// line is an error of that. Not during a run.
template <class State>
std::vector<std::string> incomplete(engine::Runtime& runtime) {
  std::vector<std::string> lines;
  runtime.visit<Instance<State>>([&](Ref<State> ref, Instance<State>& instance) {
    for (const std::string& line : instance.core().incomplete()) {
      lines.push_back(engine::text("object ", ref.id, ": ", line));
    }
  });
  return lines;
}

}  // namespace weft::graph::dataflow

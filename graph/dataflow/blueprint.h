// The typed builder of task graphs: one blueprint, of which every instance has the graph.
//
//     struct Subdomain {
//       std::vector<Ref<Subdomain>> neighbours;
//       template <class Archive> void serialize(Archive& archive) { archive(neighbours); }
//
//       double adapt(NodeContext& context, double size);
//       void propose(NodeContext& context, double quality) {
//         const std::uint64_t round = context.round();
//         for (const auto& other : neighbours) context.send<&Subdomain::gather>(other, round, quality);
//         context.expect<&Subdomain::gather>(round, neighbours);
//       }
//       void gather(NodeContext& context, std::uint64_t round, std::vector<Arrival<double>> qualities);
//
//       static Blueprint<Subdomain> blueprint() {
//         Blueprint<Subdomain> g("subdomain");
//         const auto adapt = g.start<&Subdomain::adapt>("adapt");
//         const auto propose = g.node<&Subdomain::propose>("propose");
//         const auto gather = g.event<&Subdomain::gather>("gather");
//         g.local(adapt, propose);
//         g.remote<double>(propose, gather);
//         return g;
//       }
//     };
//
//     engine::Registry registry;
//     register_blueprint<Subdomain>(registry);
//     ...
//     runtime.run([](engine::Context& context) {
//       start<&Subdomain::adapt>(context, create<Subdomain>(context), /*round=*/0, 0.5);
//     });
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "engine/objects/registry.h"
#include "graph/dataflow/instance.h"
#include "graph/dataflow/structure.h"
#include "graph/dataflow/type_name.h"

namespace weft::graph::dataflow {

/// A node with its types, to declare edges with.
template <class S, class In, class Out>
struct Node {
  using State = S;
  using Input = In;
  using Output = Out;
  NodeIndex index = 0;
};

/// An event with its types: it receives values of type V and passes on an Out.
template <class S, class V, class Out>
struct Event {
  using State = S;
  using Value = V;
  using Output = Out;
  NodeIndex index = 0;
};

/// Declares the graph of State's instances. Bodies are methods of State:
///
///     Out State::body(NodeContext&)             of nodes; Out may be void, or std::optional<T>, which passes
///     Out State::body(NodeContext&, In)         a T on or, when empty, nothing; or std::variant<T, U...>,
///                                               which passes what it holds to the nodes that take it; or
///                                               an optional of such
///     Out State::body(NodeContext&, std::uint64_t round, std::vector<Arrival<Value>>)       of events
///
/// Values of starts and events travel: they are packed (engine/base/serialize.h) and have a default
/// constructor. A node runs once for each value that is passed to it. Nodes of one instance run one at a
/// time. Each body and each name is used once. Misuse throws std::logic_error that names graph, nodes and
/// edge.
template <class State>
class Blueprint {
 public:
  explicit Blueprint(std::string name) : structure_(std::move(name)) {}

  /// A node that runs when a local predecessor passes a value on.
  template <auto Body>
  auto node(std::string name) {
    return add<Body>(std::move(name), NodeKind::interior);
  }

  /// One that the program may run too, by start(). Its input is packed.
  template <auto Body>
  auto start(std::string name) {
    auto node = add<Body>(name, NodeKind::start);
    methods_.push_back({"start " + std::move(name), [](Entry& entry, const std::string& method) {
                          entry.template method<&Instance<State>::template start<Body>>(method);
                        }});
    return node;
  }

  /// A node that runs in a round once all instances of a set have sent it a value for that round. The set is
  /// declared by NodeContext::expect(), before or after values come.
  template <auto Body>
  auto event(std::string name) {
    using Traits = detail::EventBodyTraits<decltype(Body)>;
    static_assert(std::is_same_v<typename Traits::State, State>, "the event's body is not of this State");
    StructureNode node;
    node.name = name;
    node.kind = NodeKind::event;
    node.body = &detail::body_key<Body>;
    node.run = &run_event<Body>;
    node.send = [](engine::Context& context, engine::ObjectId target, std::uint64_t round,
                   engine::Payload value) {
      context.invoke<&Instance<State>::template arrive<Body>>(Ref<State>{target}, context.self(), round,
                                                              std::move(value));
    };
    node.fire = [](engine::Context& context, std::uint64_t round, engine::Seconds seconds) {
      context.invoke_expecting<&Instance<State>::template fire<Body>>(seconds, Ref<State>{context.self()},
                                                                      round);
    };
    methods_.push_back({name, [](Entry& entry, const std::string& method) {
                          entry.template method<&Instance<State>::template fire<Body>>(method);
                        }});
    methods_.push_back({"value for " + std::move(name), [](Entry& entry, const std::string& method) {
                          entry.template method<&Instance<State>::template arrive<Body>>(method);
                        }});
    return Event<State, typename Traits::Value, typename Traits::Output>{
        structure_.add_node(std::move(node))};
  }

  /// A node `Out State::body(NodeContext&, std::uint64_t round)` that runs when the first value of a round
  /// comes that the event has not been declared for: a dormant instance may wake up and join the round.
  /// Values wait until it is declared, here or later.
  template <auto Body, class Value, class Out>
  auto wakes(Event<State, Value, Out> event, std::string name) {
    auto node = add<Body>(std::move(name), NodeKind::wake);
    static_assert(std::is_same_v<typename decltype(node)::Input, std::uint64_t>,
                  "a body that wakes must be Out State::body(NodeContext&, std::uint64_t round)");
    structure_.add_wake(event.index, node.index);
    return node;
  }

  /// What `from` passes on is the input of `to`, in the same round or the next. A successor that takes
  /// nothing may follow any node.
  template <class From, class To>
  void local(From from, To to, RoundStep step = RoundStep::same) {
    using Output = typename From::Output;
    static_assert(std::is_same_v<typename From::State, State> && std::is_same_v<typename To::State, State>,
                  "a local edge joins nodes of one blueprint");
    static_assert(
        requires { typename To::Input; },
        "a local edge cannot end at an event: its values come along remote edges");
    static_assert(detail::Fits<Output, typename To::Input>::value,
                  "the output of the first node is not the input of the second");
    using Value = std::conditional_t<std::is_same_v<typename To::Input, Nothing>, Output, typename To::Input>;
    structure_.add_local(from.index, to.index, step, std::is_copy_constructible_v<Output>,
                         type_name<Value>());
  }

  /// The body of `from` may send values to the event of any instance: NodeContext::send().
  template <class Value, class From, class To>
  void remote(From from, To to) {
    static_assert(std::is_same_v<typename From::State, State> && std::is_same_v<typename To::State, State>,
                  "a remote edge joins nodes of one blueprint");
    static_assert(
        requires { typename To::Value; }, "a remote edge ends at an event");
    static_assert(std::is_same_v<Value, typename To::Value>,
                  "the value of the edge is not what the event receives");
    structure_.add_remote(from.index, to.index, type_name<Value>());
  }

  const Structure& structure() const { return structure_; }
  const GraphDescription& description() const { return structure_.description(); }

  /// Names the instances' type and methods to the engine.
  void register_methods(engine::Registry& registry) const {
    Entry entry = registry.type<Instance<State>>(structure_.name());
    for (const auto& [name, add] : methods_) add(entry, name);
  }

 private:
  using Entry = engine::Registry::Entry<Instance<State>>;
  struct Method {
    std::string name;
    void (*add)(Entry& entry, const std::string& name);
  };

  template <auto Body>
  auto add(std::string name, NodeKind kind) {
    using Traits = detail::BodyTraits<decltype(Body)>;
    static_assert(std::is_same_v<typename Traits::State, State>, "the node's body is not of this State");
    StructureNode node;
    node.name = std::move(name);
    node.kind = kind;
    node.body = &detail::body_key<Body>;
    node.input = detail::input_key<typename Traits::Input>();
    node.run = &run_node<Body>;
    return Node<State, typename Traits::Input, typename Traits::Output>{structure_.add_node(std::move(node))};
  }

  template <auto Body>
  static Passed run_node(void* state, NodeContext& context, void* input, bool consume);
  template <auto Body>
  static Passed run_event(void* state, NodeContext& context, void* input, bool consume);

  Structure structure_;
  std::vector<Method> methods_;
};

namespace detail {

template <class... Alternatives>
Passed passed(std::variant<Alternatives...>&& result) {
  return std::visit(
      []<class T>(T&& value) {
        using Value = std::decay_t<T>;
        return Passed{std::make_shared<Value>(std::forward<T>(value)), &type_key<Value>};
      },
      std::move(result));
}
template <class... Alternatives>
Passed passed(std::optional<std::variant<Alternatives...>>&& result) {
  return result ? passed(std::move(*result)) : Passed{};
}
template <class T>
Passed passed(std::optional<T>&& result) {
  return {result ? std::make_shared<T>(std::move(*result)) : nullptr};
}
template <class T>
Passed passed(T&& result) {
  return {std::make_shared<std::decay_t<T>>(std::forward<T>(result))};
}

/// Calls a body and wraps what it passes on.
template <class Call>
Passed result_of(const Call& call) {
  if constexpr (std::is_void_v<decltype(call())>) {
    static Nothing nothing;
    call();
    return {{std::shared_ptr<void>(), &nothing}};
  } else {
    return passed(call());
  }
}

}  // namespace detail

template <class State>
template <auto Body>
Passed Blueprint<State>::run_node(void* state, NodeContext& context, void* input, bool consume) {
  using Input = typename detail::BodyTraits<decltype(Body)>::Input;
  auto& self = *static_cast<State*>(state);
  if constexpr (std::is_invocable_v<decltype(Body), State&, NodeContext&>) {
    return detail::result_of([&] { return (self.*Body)(context); });
  } else if constexpr (std::is_same_v<Input, Nothing>) {  // what has come may be of any type
    return detail::result_of([&] { return (self.*Body)(context, Nothing{}); });
  } else {
    auto& value = *static_cast<Input*>(input);
    if constexpr (std::is_invocable_v<decltype(Body), State&, NodeContext&, const Input&>) {
      if (!consume) return detail::result_of([&] { return (self.*Body)(context, std::as_const(value)); });
    }
    return detail::result_of([&] { return (self.*Body)(context, std::move(value)); });
  }
}

template <class State>
template <auto Body>
Passed Blueprint<State>::run_event(void* state, NodeContext& context, void* input, bool) {
  using Value = typename detail::EventBodyTraits<decltype(Body)>::Value;
  std::vector<Arrival<Value>> arrivals;
  auto& packed = *static_cast<PackedArrivals*>(input);
  arrivals.reserve(packed.size());
  for (auto& [from, payload] : packed) {
    engine::Unpacker unpacker(std::move(payload));
    arrivals.push_back({from, {}});
    unpacker(arrivals.back().value);
    unpacker.finish();
  }
  packed.clear();
  auto& self = *static_cast<State*>(state);
  return detail::result_of([&] { return (self.*Body)(context, context.round(), std::move(arrivals)); });
}

/// State's blueprint, made at the first call; see structure_of().
template <class State>
const Blueprint<State>& blueprint_of() {
  static const Blueprint<State> blueprint = State::blueprint();
  return blueprint;
}
template <class State>
const Structure& structure_of() {
  return blueprint_of<State>().structure();
}

/// On every rank, before the runtime starts: instances of State are mobile objects whose type has the
/// blueprint's name.
template <class State>
void register_blueprint(engine::Registry& registry) {
  blueprint_of<State>().register_methods(registry);
}

}  // namespace weft::graph::dataflow

// What the signatures of node bodies say: the types of a task graph's values.
#pragma once

#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "engine/objects/registry.h"

namespace weft::graph::dataflow {

class NodeContext;
template <class State>
class Instance;

/// An instance of State's blueprint, anywhere in the run; valid wherever it moves. Plain data, may be sent.
template <class State>
using Ref = engine::MobilePtr<Instance<State>>;

/// The value that the instance `from` has sent to an event.
using engine::Arrival;
/// The value of an edge that carries none.
using engine::Nothing;

namespace detail {

/// One address for each body, in whatever source it is named.
template <auto Body>
[[gnu::visibility("hidden")]] inline constexpr char body_key = 0;  // GCC forgets -fvisibility here
/// One address for each type of values; none for Nothing, which takes whatever comes.
template <class T>
[[gnu::visibility("hidden")]] inline constexpr char type_key = 0;
template <class T>
constexpr const void* input_key() {
  return std::is_same_v<T, Nothing> ? nullptr : &type_key<T>;
}

template <class T>
inline constexpr bool kNever = false;

/// What a body's result passes on: void passes Nothing, an optional its value if it has one, a variant what
/// it holds.
template <class Result>
struct ResultTraits {
  using Output = std::decay_t<Result>;
};
template <>
struct ResultTraits<void> {
  using Output = Nothing;
};
template <class T>
struct ResultTraits<std::optional<T>> {
  using Output = T;
};

/// Whether a node that takes In may follow one that passes on Out.
template <class Out, class In>
struct Fits : std::bool_constant<std::is_same_v<In, Out> || std::is_same_v<In, Nothing>> {};
template <class... Alternatives, class In>
struct Fits<std::variant<Alternatives...>, In>
    : std::bool_constant<(std::is_same_v<In, Alternatives> + ...) == 1 || std::is_same_v<In, Nothing>> {};

template <class T>
struct BodyTraits {
  static_assert(kNever<T>,
                "a node's body must be Out State::body(NodeContext&) or Out State::body(NodeContext&, In)");
};
template <class S, class Result>
struct BodyTraits<Result (S::*)(NodeContext&)> {
  using State = S;
  using Input = Nothing;
  using Output = typename ResultTraits<Result>::Output;
};
template <class S, class Result, class In>
struct BodyTraits<Result (S::*)(NodeContext&, In)> {
  static_assert(!std::is_reference_v<In> || std::is_same_v<In, const std::decay_t<In>&>,
                "a node's body must take its input by value or by reference to const");
  using State = S;
  using Input = std::decay_t<In>;
  using Output = typename ResultTraits<Result>::Output;
};

template <class T>
struct EventBodyTraits {
  static_assert(kNever<T>,
                "an event's body must be "
                "Out State::body(NodeContext&, std::uint64_t round, std::vector<Arrival<Value>>)");
};
template <class S, class Result, class V>
struct EventBodyTraits<Result (S::*)(NodeContext&, std::uint64_t, std::vector<Arrival<V>>)> {
  using State = S;
  using Value = V;
  using Output = typename ResultTraits<Result>::Output;
};

}  // namespace detail
}  // namespace weft::graph::dataflow

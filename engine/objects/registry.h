// The types of mobile objects and their methods: what a message may call.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/base/rank.h"
#include "engine/base/serialize.h"
#include "engine/objects/event.h"
#include "engine/objects/message.h"

namespace weft::engine {

class Context;

/// The name of an object of type T anywhere in the run; valid wherever the object moves. Plain data, may be
/// sent.
template <class T>
struct MobilePtr {
  ObjectId id;
  friend auto operator<=>(MobilePtr, MobilePtr) = default;
};

/// The value that `from` has signalled to an event.
template <class Value>
struct Arrival {
  ObjectId from;
  Value value;
};

/// For signals that carry no value.
struct Nothing {
  template <class Archive>
  void serialize(Archive&) {}
};

/// An event, by name, and who is missing.
struct NamedWait {
  std::string event;
  EventWait wait;
};

/// What an object says of itself while a run lasts (scheduler_state.cpp).
struct ObjectState {
  std::string what;              ///< "round 3, 12000 tets"; may be empty
  std::vector<NamedWait> waits;  ///< for events that it keeps itself, beside the engine's
};

/// The type of an object without its type.
struct TypeInfo {
  std::string name;
  std::uint32_t id = 0;  ///< hash of the name: what travels
  bool movable = false;
  Payload (*pack)(void* object) = nullptr;  ///< which leaves an empty shell
  Payload (*copy)(void* object) = nullptr;
  void* (*unpack)(Payload payload) = nullptr;
  void (*destroy)(void* object) = nullptr;
  ObjectState (*describe)(const void* object) = nullptr;  ///< null: it has nothing to say
};

struct MethodInfo {
  std::string name;         ///< "Counter::add"
  std::uint32_t id = 0;     ///< hash of the name
  std::uint32_t index = 0;  ///< in order of registration: for counters
  std::uint32_t type = 0;   ///< id of its type
  void (*call)(void* object, Context& context, Task& task) = nullptr;
};

namespace detail {

/// One address for each method (and type), in whatever source it is named.
template <auto Method>
[[gnu::visibility("hidden")]] inline constexpr char method_key = 0;  // GCC forgets -fvisibility here
template <class T>
[[gnu::visibility("hidden")]] inline constexpr char type_key = 0;

template <class T>
concept Movable = requires(T& value, Packer& packer, Unpacker& unpacker) {
  value.serialize(packer);
  value.serialize(unpacker);
}
&&std::is_default_constructible_v<T>;

template <class T>
concept Described = requires(const T& value) {
  { value.describe() } -> std::same_as<ObjectState>;
};

template <class T>
struct MethodTraits;
template <class T, class... Args>
struct MethodTraits<void (T::*)(Context&, Args...)> {
  using Object = T;
  using Arguments = std::tuple<std::decay_t<Args>...>;
};
template <class T>
struct EventTraits;
template <class T, class Value>
struct EventTraits<void (T::*)(Context&, std::uint64_t, std::vector<Arrival<Value>>)> {
  using Object = T;
  using Argument = Value;
};

template <auto Method>
void call_method(void* object, Context& context, Task& task) {
  using Traits = MethodTraits<decltype(Method)>;
  typename Traits::Arguments arguments{};
  Unpacker unpacker(std::move(task.payload));
  unpacker(arguments);
  unpacker.finish();
  std::apply(
      [&](auto&... parts) {
        (static_cast<typename Traits::Object*>(object)->*Method)(context, std::move(parts)...);
      },
      arguments);
}

template <auto Event>
void call_event(void* object, Context& context, Task& task) {
  using Traits = EventTraits<decltype(Event)>;
  std::vector<Arrival<typename Traits::Argument>> arrivals;
  arrivals.reserve(task.arrivals.size());
  for (auto& [from, payload] : task.arrivals) {
    Unpacker unpacker(std::move(payload));
    arrivals.push_back({from, {}});
    unpacker(arrivals.back().value);
    unpacker.finish();
  }
  task.arrivals.clear();
  (static_cast<typename Traits::Object*>(object)->*Event)(context, task.envelope.round, std::move(arrivals));
}

}  // namespace detail

/// Filled by the application, alike on all ranks, before the runtime starts; constant afterwards.
/// Throws std::logic_error when a name is used twice or two names share a hash.
class Registry {
 public:
  /// Names the methods of one type.
  template <class T>
  class Entry {
   public:
    Entry(Registry& registry, std::uint32_t type) : registry_(registry), type_(type) {}

    /// A method `void T::Method(Context&, arguments...)`; the arguments are packed by value.
    template <auto Method>
    Entry& method(std::string_view name) {
      static_assert(std::is_same_v<typename detail::MethodTraits<decltype(Method)>::Object, T>);
      registry_.add_method(&detail::method_key<Method>, type_, name, &detail::call_method<Method>);
      return *this;
    }

    /// An event `void T::Event(Context&, std::uint64_t round, std::vector<Arrival<Value>> arrivals)`.
    template <auto Event>
    Entry& event(std::string_view name) {
      static_assert(std::is_same_v<typename detail::EventTraits<decltype(Event)>::Object, T>);
      registry_.add_method(&detail::method_key<Event>, type_, name, &detail::call_event<Event>);
      return *this;
    }

   private:
    Registry& registry_;
    std::uint32_t type_;
  };

  /// A type of mobile objects. One with serialize() and a default constructor can move; others stay where
  /// they are made. One with `ObjectState describe() const` is asked by Runtime::request_state(), between its
  /// handlers.
  template <class T>
  Entry<T> type(std::string_view name) {
    TypeInfo info;
    info.name = name;
    info.destroy = [](void* object) { delete static_cast<T*>(object); };
    if constexpr (detail::Described<T>) {
      info.describe = [](const void* object) { return static_cast<const T*>(object)->describe(); };
    }
    if constexpr (detail::Movable<T>) {
      info.movable = true;
      info.pack = [](void* object) {
        Packer packer(true);
        static_cast<T*>(object)->serialize(packer);
        return packer.take();
      };
      info.copy = [](void* object) {
        Packer packer;
        static_cast<T*>(object)->serialize(packer);
        return packer.take();
      };
      info.unpack = [](Payload payload) -> void* {
        auto object = std::make_unique<T>();
        Unpacker unpacker(std::move(payload));
        object->serialize(unpacker);
        unpacker.finish();
        return object.release();
      };
    }
    return Entry<T>(*this, add_type(&detail::type_key<T>, std::move(info)));
  }

  /// By what the program names. Throw std::logic_error for what was not registered.
  template <auto Method>
  const MethodInfo& method() const {
    return method_of(&detail::method_key<Method>);
  }
  template <class T>
  const TypeInfo& type() const {
    return type_of(&detail::type_key<T>);
  }

  /// By what a message names; null for what was not registered.
  const MethodInfo* find_method(std::uint32_t id) const;
  const TypeInfo* find_type(std::uint32_t id) const;

  /// Names of the methods by index.
  std::vector<std::string> method_names() const;
  std::size_t methods() const { return methods_.size(); }

  /// The same for registries with the same types and methods: their names, and which types can move.
  std::uint64_t fingerprint() const;

 private:
  std::uint32_t add_type(const void* key, TypeInfo info);
  void add_method(const void* key, std::uint32_t type, std::string_view name,
                  void (*call)(void*, Context&, Task&));
  const MethodInfo& method_of(const void* key) const;
  const TypeInfo& type_of(const void* key) const;

  std::vector<std::unique_ptr<MethodInfo>> methods_;
  std::vector<std::unique_ptr<TypeInfo>> types_;
  std::unordered_map<const void*, const MethodInfo*> method_by_key_;
  std::unordered_map<const void*, const TypeInfo*> type_by_key_;
  std::unordered_map<std::uint32_t, const MethodInfo*> method_by_id_;
  std::unordered_map<std::uint32_t, const TypeInfo*> type_by_id_;
};

}  // namespace weft::engine

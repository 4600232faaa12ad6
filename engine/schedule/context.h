// What a handler can do: the engine as seen from inside a method of a mobile object.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/objects/registry.h"

namespace weft::engine {

class Scheduler;
struct Cell;

/// How long the application expects a handler to take; the balancer goes by it, corrected by what it
/// measures.
struct Seconds {
  double value = 0;
};

/// Given to every handler, for the time of its run. Its functions may be called from all threads that work
/// for the handler. Sending waits only when very much is unsent (exchange.h).
/// Errors of use throw std::logic_error.
class Context {
 public:
  Context(Scheduler& scheduler, Cell& self) : scheduler_(scheduler), self_(self) {}
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  Rank rank() const;
  int ranks() const;

  /// What the program has given this rank: RuntimeOptions::local. Objects reach by it what all of a rank
  /// share and what does not move with them.
  template <class T>
  const T& local() const {
    return *static_cast<const T*>(local_data());
  }

  /// The object whose handler this is; the rank's root object in the function that a run starts with.
  ObjectId self() const;

  /// Makes an object on this rank.
  template <class T, class... Args>
  MobilePtr<T> create(Args&&... args) {
    const TypeInfo& type = registry().type<T>();
    return {add_object(type, new T(std::forward<Args>(args)...))};
  }

  /// Calls Method on the object, wherever it is, some time after this. From one sender to one object,
  /// messages are handled in the order in which they were sent. The arguments are converted to the method's
  /// parameter types and consumed.
  template <auto Method, class T, class... Args>
  void invoke(MobilePtr<T> target, Args&&... args) {
    invoke_expecting<Method>(Seconds{0}, target, std::forward<Args>(args)...);
  }
  template <auto Method, class T, class... Args>
  void invoke_expecting(Seconds expected, MobilePtr<T> target, Args&&... args) {
    using Traits = detail::MethodTraits<decltype(Method)>;
    static_assert(std::is_same_v<typename Traits::Object, T>);
    typename Traits::Arguments arguments(std::forward<Args>(args)...);
    Packer packer(true);
    packer(arguments);
    send(Request::invoke, target.id, registry().method<Method>().id, 0, expected, packer.take());
  }

  /// This object's Event is to run, in `round`, once each of `dependencies` has signalled it; at once if
  /// there are none. The set may differ from round to round, and signals may come before this.
  template <auto Event>
  void expect(std::uint64_t round, std::vector<ObjectId> dependencies, Seconds expected = {}) {
    declare_event(registry().method<Event>().id, round, std::move(dependencies), expected);
  }

  /// This object's contribution to the target's Event in `round`: once a round, and only if it is a
  /// dependency of it.
  template <auto Event, class T, class Value = Nothing>
  void signal(MobilePtr<T> target, std::uint64_t round, Value value = {}) {
    using Traits = detail::EventTraits<decltype(Event)>;
    static_assert(std::is_same_v<typename Traits::Object, T>);
    static_assert(std::is_same_v<typename Traits::Argument, Value>);
    Packer packer(true);
    packer(value);
    send(Request::signal, target.id, registry().method<Event>().id, round, {}, packer.take());
  }

  /// The object is destroyed after the messages that this sender has sent it before. Whatever reaches it
  /// later fails the run.
  template <class T>
  void destroy(MobilePtr<T> target) {
    send(Request::destroy, target.id, 0, 0, {}, {});
  }

  /// The object moves to `to` after the messages that this sender has sent it before; what waits for it goes
  /// along.
  template <class T>
  void migrate(MobilePtr<T> target, Rank to) {
    send(Request::migrate, target.id, 0, static_cast<std::uint64_t>(to.value), {}, {});
  }

  /// Workers of this rank that have nothing to do now. Parallel loops of oneTBB inside the handler run on
  /// them too.
  int idle_workers() const;

  /// The run has failed or was interrupted: a long handler should return soon.
  bool stop_requested() const;
  /// The same as a flag, for what is to look at it often; it lives as long as the runtime.
  const std::atomic<bool>& stop_flag() const;

 private:
  const void* local_data() const;
  const Registry& registry() const;
  ObjectId add_object(const TypeInfo& type, void* object);
  void send(Request request, ObjectId target, std::uint32_t method, std::uint64_t round, Seconds expected,
            Payload payload);
  void declare_event(std::uint32_t method, std::uint64_t round, std::vector<ObjectId> dependencies,
                     Seconds expected);

  Scheduler& scheduler_;
  Cell& self_;
};

}  // namespace weft::engine

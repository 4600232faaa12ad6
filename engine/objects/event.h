// The events of one object: methods that run once all their dependencies have arrived.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/rank.h"
#include "engine/base/serialize.h"

namespace weft::engine {

/// An event is named by the method it calls and a round, so that the same event may wait in many rounds at
/// once.
struct EventKey {
  std::uint32_t method = 0;
  std::uint64_t round = 0;
  friend auto operator<=>(const EventKey&, const EventKey&) = default;
};

/// All dependencies of an event have arrived. Their values are in the order in which the dependencies were
/// declared, whatever order they came in: what a method computes from them does not depend on the network.
struct FiredEvent {
  EventKey key;
  double expected = 0;
  std::vector<std::pair<ObjectId, Payload>> arrivals;
};

/// An event that lacks arrivals, or arrivals that lack an event; for the dump of a stalled run.
struct EventWait {
  EventKey key;
  bool declared = false;
  std::vector<ObjectId> missing;  ///< dependencies that have not arrived; empty when not declared
  std::vector<ObjectId> arrived;
};

/// Part of an object's state that travels with it. Signals may come before the event is declared: they wait.
/// Errors of the application (std::logic_error): an event declared twice, an arrival from no dependency or
/// twice.
class EventTable {
 public:
  /// The object waits for one arrival from each of `dependencies`; none: it fires at once.
  std::optional<FiredEvent> declare(EventKey key, std::vector<ObjectId> dependencies, double expected);

  std::optional<FiredEvent> arrive(EventKey key, ObjectId from, Payload value);

  bool empty() const { return pending_.empty(); }
  std::vector<EventWait> waits() const;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(pending_);
  }

 private:
  struct Pending {
    bool declared = false;
    double expected = 0;
    std::vector<ObjectId> dependencies;
    std::map<ObjectId, Payload> arrived;

    template <class Archive>
    void serialize(Archive& archive) {
      archive(declared, expected, dependencies, arrived);
    }
  };

  std::optional<FiredEvent> fire_if_complete(EventKey key, Pending& pending);

  std::map<EventKey, Pending> pending_;
};

}  // namespace weft::engine

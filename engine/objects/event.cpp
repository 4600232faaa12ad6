// Waiting and firing.
#include "engine/objects/event.h"

#include <algorithm>
#include <stdexcept>

#include "engine/base/text.h"

namespace weft::engine {
namespace {

template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw std::logic_error(text(parts...));
}

bool contains(const std::vector<ObjectId>& ids, ObjectId id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

}  // namespace

std::optional<FiredEvent> EventTable::declare(EventKey key, std::vector<ObjectId> dependencies,
                                              double expected) {
  Pending& pending = pending_[key];
  if (pending.declared) refuse("the event waits already in round ", key.round);
  for (std::size_t i = 0; i < dependencies.size(); ++i) {
    if (std::find(dependencies.begin(), dependencies.begin() + i, dependencies[i]) !=
        dependencies.begin() + i) {
      refuse("object ", dependencies[i], " is a dependency twice in round ", key.round);
    }
  }
  for (const auto& [from, value] : pending.arrived) {
    if (!contains(dependencies, from)) {
      refuse("object ", from, " has signalled round ", key.round, " but is no dependency of it");
    }
  }
  pending.declared = true;
  pending.expected = expected;
  pending.dependencies = std::move(dependencies);
  return fire_if_complete(key, pending);
}

std::optional<FiredEvent> EventTable::arrive(EventKey key, ObjectId from, Payload value) {
  Pending& pending = pending_[key];
  if (pending.declared && !contains(pending.dependencies, from)) {
    refuse("object ", from, " signals round ", key.round, " but is no dependency of it");
  }
  if (!pending.arrived.try_emplace(from, std::move(value)).second) {
    refuse("object ", from, " signals round ", key.round, " twice");
  }
  return fire_if_complete(key, pending);
}

std::optional<FiredEvent> EventTable::fire_if_complete(EventKey key, Pending& pending) {
  if (!pending.declared || pending.arrived.size() < pending.dependencies.size()) return std::nullopt;
  FiredEvent fired{key, pending.expected, {}};
  fired.arrivals.reserve(pending.dependencies.size());
  for (const ObjectId from : pending.dependencies) {
    fired.arrivals.emplace_back(from, std::move(pending.arrived.at(from)));
  }
  pending_.erase(key);
  return fired;
}

std::vector<EventWait> EventTable::waits() const {
  std::vector<EventWait> waits;
  for (const auto& [key, pending] : pending_) {
    EventWait wait{key, pending.declared, {}, {}};
    for (const auto& [from, value] : pending.arrived) wait.arrived.push_back(from);
    for (const ObjectId from : pending.dependencies) {
      if (!pending.arrived.contains(from)) wait.missing.push_back(from);
    }
    waits.push_back(std::move(wait));
  }
  return waits;
}

}  // namespace weft::engine

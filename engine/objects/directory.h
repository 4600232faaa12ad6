// Where each object is, as far as this rank knows.
//
// An object's *age* is the number of its moves: it is created at age 0 at its home and has age n after n
// moves. A location is a rank with the age at which the object came, or will come, there. Two rules make
// every message arrive without any order on the network:
//   1. A rank that sends an object away remembers where to, at its new age. So from any location of age n
//   that the object
//      has left, the one of age n + 1 is known there.
//   2. A message that finds no object is sent on only by a location *newer* than the one it was sent by; if
//   this rank
//      knows none, then the object is still on its way here, and the message waits for it.
// Each hop raises the age, so no message goes in circles, and it arrives once the object rests.
// Locations learnt otherwise (home is told of every move, a sender whose message was forwarded is told where
// it ended) only shorten the way.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "engine/base/rank.h"

namespace weft::engine {

struct Location {
  Rank rank;
  std::uint32_t age = 0;
};

/// Not synchronised: the rank's scheduler calls it under its lock.
class Directory {
 public:
  explicit Directory(Rank here) : here_(here) {}

  /// Where to send a message to an object that is not here: what is known, else its home.
  Location best_guess(ObjectId id) const;

  /// Rule 2: where a message sent by a location of `age` to this rank goes on to, nothing if it must wait
  /// here.
  std::optional<Location> newer(ObjectId id, std::uint32_t age) const;

  /// The object is, or will be, there; older news than what is known is ignored.
  void learn(ObjectId id, Location location);

  /// The object came here: what was known of it before is of no use.
  void arrived(ObjectId id) { known_.erase(id); }

  /// The object is no more. Remembered by the rank where it ended and by its home.
  void destroyed(ObjectId id);

  /// Whether an object that is not here was destroyed. `created` is the number of objects that this rank has
  /// created.
  bool is_gone(ObjectId id, std::uint32_t created) const;

  /// Whether it is one that this rank has not created yet: ids may be told ahead, their messages wait.
  bool is_to_come(ObjectId id, std::uint32_t created) const {
    return id.home == here_ && id.number > created && !known_.contains(id);
  }

 private:
  Rank here_;
  std::unordered_map<ObjectId, Location> known_;
  std::unordered_set<ObjectId> destroyed_;
};

}  // namespace weft::engine

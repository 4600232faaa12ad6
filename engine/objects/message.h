// A message to a mobile object, and the form in which it waits to be handled.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "engine/base/rank.h"
#include "engine/base/serialize.h"

namespace weft::engine {

/// What a message asks of its object.
enum class Request : std::uint8_t {
  invoke,  ///< call a method with the arguments in the payload
  signal,  ///< a dependency of an event has arrived, with its value
  fire,  ///< all dependencies of an event have arrived: call its method (made where the object is; never sent
         ///< alone)
  destroy,  ///< destroy the object
  migrate,  ///< move to the rank in `round`
};

/// Everything about a message but its payload.
struct Envelope {
  ObjectId target;
  ObjectId sender;
  std::uint64_t sequence =
      0;  ///< number among the messages of this sender to this target: delivered in this order
  std::uint64_t round = 0;   ///< of the event
  std::uint64_t id = 0;      ///< unique in the run, for timelines; 0: none
  std::uint64_t epoch = 0;   ///< of its sender when it was sent, see snapshot.h
  double expected = 0;       ///< seconds it will take, as the application expects; 0: it did not say
  std::uint32_t method = 0;  ///< hash of the method's name
  std::uint32_t age = 0;     ///< of the location it was sent by, see directory.h
  Rank origin;               ///< the rank of the sender when it was sent
  std::uint16_t hops = 0;    ///< ranks it has visited in vain
  Request request = Request::invoke;
};
static_assert(PlainData<Envelope>);

struct MethodInfo;

/// A message at its object.
struct Task {
  Envelope envelope;
  Payload payload;
  std::vector<std::pair<ObjectId, Payload>>
      arrivals;  ///< of an event that fires, in the order of its dependencies

  // Of the rank where it waits; they do not travel.
  const MethodInfo* info = nullptr;  ///< of its method; null if there is none of this name here
  double predicted = 0;              ///< seconds, by the cost model
  Rank from;                         ///< the rank that must be told when it is consumed, if any (exchange.h)
  std::size_t wire_bytes = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(envelope, payload, arrivals);
  }
};

}  // namespace weft::engine

// What a rank has to do, as policies see it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/base/rank.h"

namespace weft::engine {

/// An object that waits to be handled and may be given away.
struct ReadyObject {
  ObjectId id;
  double seconds = 0;  ///< predicted, of all its messages
};

/// What a rank has to do.
struct Load {
  int workers = 0;
  int busy = 0;               ///< workers that run a handler
  std::size_t ready = 0;      ///< objects that wait for a worker
  double queued_seconds = 0;  ///< predicted, of all messages that wait
  std::uint64_t handled = 0;  ///< messages so far
};

}  // namespace weft::engine

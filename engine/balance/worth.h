// When an object is worth moving.
#pragma once

#include <optional>

#include "engine/balance/balancer.h"

namespace weft::engine {

/// Seconds of work that an object must have to be moved: so many times what moving takes. A rank that is idle
/// for a moment gets work from its messages soon, and what it would take for so little is missed where it
/// was.
inline double worth_moving(const BalanceActions& actions) {
  constexpr double kLeastGain = 4;
  return kLeastGain * actions.move_seconds().value_or(0);
}

}  // namespace weft::engine

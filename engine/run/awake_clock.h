// Time that stands still while the process is suspended.
#pragma once

#include <algorithm>

#include "engine/trace/trace.h"

namespace weft::engine {

/// Counts the time between two calls of tick(), but at most kLongestGap: its owner calls it several times a
/// second, and a longer gap means that the process was stopped (by a signal, a debugger, the batch system) or
/// had no processor. What others did in that time it could not hear, so limits on waiting do not count it.
class AwakeClock {
 public:
  static constexpr TimePoint kLongestGap = 500'000'000;

  /// `now` is that of trace.h. Returns time().
  TimePoint tick(TimePoint now) {
    if (last_ > 0) time_ += std::clamp<TimePoint>(now - last_, 0, kLongestGap);
    last_ = now;
    return time_;
  }

  /// At the last tick; above 0.
  TimePoint time() const { return time_; }

 private:
  TimePoint last_ = 0;
  TimePoint time_ = 1;
};

}  // namespace weft::engine

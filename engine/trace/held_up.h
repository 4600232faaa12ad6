// How long a thread has waited for a processor that others had.
#pragma once

#include "engine/trace/trace.h"

namespace weft::engine {

/// Nanoseconds that the calling thread has been ready to run and did not, since it began, by Linux
/// (/proc/thread-self/schedstat); 0 where the system does not say.
TimePoint held_up();

/// The same, for many readings: the system, which takes 1 us, is asked only where so much time has passed
/// since the last reading that it would matter. Of one thread.
class HeldUpClock {
 public:
  /// Until `time`, which is now(). Simulated ranks wait on no clock of the system.
  TimePoint until(TimePoint time) {
    constexpr TimePoint kMatters = 200'000;
    if (VirtualTime::of_thread() != nullptr) return 0;
    if (time - read_ >= kMatters) held_up_ = held_up();
    read_ = time;
    return held_up_;
  }

 private:
  TimePoint read_ = 0, held_up_ = 0;
};

}  // namespace weft::engine

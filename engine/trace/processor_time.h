// What a thread has had of a processor.
#pragma once

#include <time.h>

#include "engine/trace/trace.h"

namespace weft::engine {

/// Nanoseconds of processor time of this thread; of a simulated rank its virtual clock. What a busy machine
/// makes a thread wait for is not in it.
inline TimePoint processor_time() {
  if (const VirtualTime* simulated = VirtualTime::of_thread()) return simulated->now();
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1'000'000'000 * time.tv_sec + time.tv_nsec;
}

}  // namespace weft::engine

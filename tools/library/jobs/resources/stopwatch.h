// Times of the steps of a job.
#pragma once

#include <utility>

#include "engine/trace/trace.h"

namespace weft::tools {

/// Seconds since it was made or last asked; of a simulated rank on its virtual clock.
class Stopwatch {
 public:
  double lap() {
    const engine::TimePoint now = engine::now();
    return 1e-9 * static_cast<double>(now - std::exchange(last_, now));
  }

 private:
  engine::TimePoint last_ = engine::now();
};

}  // namespace weft::tools

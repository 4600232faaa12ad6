// Ranks that share the cores of one machine: how far their workers get.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/trace/trace.h"

namespace weft::engine {

/// Workers of all ranks that run share the cores evenly, as under a scheduler whose slices are short. All get
/// on at one rate, so what a worker that runs all the time has worked is one function of time for all of
/// them. Nanoseconds.
class SharedCores {
 public:
  /// 0: each worker has its own, and has worked as long as it is.
  explicit SharedCores(int cores) : cores_(cores) {}

  /// Clocks of ranks differ within a turn: before the last change it is what it was at that.
  TimePoint worked(TimePoint time) const {
    if (cores_ == 0) return time;
    return std::llround(worked_ + rate() * static_cast<double>(std::max<TimePoint>(time - time_, 0)));
  }
  /// The first time by which so much is worked, unless workers begin or end before.
  TimePoint when(TimePoint worked_then) const {
    if (cores_ == 0) return worked_then;
    const double missing = std::max(0.0, static_cast<double>(worked_then) - worked_);
    TimePoint time = time_ + static_cast<TimePoint>(missing / rate());
    while (worked(time) < worked_then) ++time;
    return time;
  }

  /// So many workers more run from then on. True when those that run get on faster.
  bool run(int more, TimePoint time) {
    const double before = rate();
    worked_ += before * static_cast<double>(std::max<TimePoint>(time - time_, 0));
    time_ = std::max(time_, time);
    running_ += more;
    return rate() > before;
  }

  /// Whoever wants to run has to wait.
  bool all_busy() const { return cores_ > 0 && running_ >= cores_; }

 private:
  double rate() const {
    return cores_ == 0 ? 1 : std::min(1.0, static_cast<double>(cores_) / std::max(running_, 1));
  }

  int cores_;
  int running_ = 0;
  TimePoint time_ = 0;  ///< of the last change
  double worked_ = 0;   ///< by then
};

}  // namespace weft::engine

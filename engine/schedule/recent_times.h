// How long something took lately.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "engine/trace/trace.h"

namespace weft::engine {

/// The latest few durations of one kind. Their median is not moved by one that was long by chance, as the
/// mean of few is.
class RecentTimes {
 public:
  void add(TimePoint nanoseconds) {
    times_[added_ % kKept] = nanoseconds;
    ++added_;
  }

  /// Of all that were ever added.
  std::size_t count() const { return added_; }

  /// Nanoseconds, the lower of two in the middle; there must be one.
  TimePoint median() const {
    std::array<TimePoint, kKept> sorted = times_;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(std::min(added_, kKept));
    const auto middle = sorted.begin() + (end - sorted.begin() - 1) / 2;
    std::nth_element(sorted.begin(), middle, end);
    return *middle;
  }

 private:
  static constexpr std::size_t kKept = 15;
  std::array<TimePoint, kKept> times_{};
  std::size_t added_ = 0;
};

}  // namespace weft::engine

// Spans of helpers.
#include "engine/schedule/helpers.h"

#include <new>

namespace weft::engine {

void Helpers::begin_run() {
  const std::lock_guard lock(mutex_);
  runs_ = true;
  for (TimePoint& since : since_)
    if (since != kNobody) since = now();
}

void Helpers::end_run() {
  const std::lock_guard lock(mutex_);
  for (std::size_t slot = 0; slot < since_.size(); ++slot) record(slot);
  runs_ = false;
}

void Helpers::enters(int slot) noexcept {
  const auto place = static_cast<std::size_t>(slot);
  const std::lock_guard lock(mutex_);
  if (place < since_.size()) since_[place] = now();
}

bool Helpers::leaves(int slot) noexcept {
  const auto place = static_cast<std::size_t>(slot);
  const std::lock_guard lock(mutex_);
  if (place >= since_.size() || since_[place] == kNobody) return false;
  record(place);
  since_[place] = kNobody;
  return true;
}

void Helpers::record(std::size_t slot) noexcept {
  if (!runs_ || since_[slot] == kNobody) return;
  try {
    trace_.helper_lane(static_cast<int>(slot))
        .span({since_[slot], now(), ObjectId{}, Span::kNoName, Activity::help, 0});
  } catch (const std::bad_alloc&) {  // it has been counted; a timeline lacks it
  }
}

}  // namespace weft::engine

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
  for (std::size_t slot = 0; slot < since_.size(); ++slot) leaves(slot);
  runs_ = false;
}

void Helpers::moved(int slot, bool enters) noexcept {
  const auto place = static_cast<std::size_t>(slot);
  const std::lock_guard lock(mutex_);
  if (place >= since_.size()) return;
  if (enters) {
    since_[place] = now();
  } else {
    leaves(place);
    since_[place] = kNobody;
  }
}

void Helpers::leaves(std::size_t slot) noexcept {
  if (!runs_ || since_[slot] == kNobody) return;
  try {
    trace_.helper_lane(static_cast<int>(slot))
        .span({since_[slot], now(), ObjectId{}, Span::kNoName, Activity::help, 0});
  } catch (const std::bad_alloc&) {  // it has been counted; a timeline lacks it
  }
}

}  // namespace weft::engine

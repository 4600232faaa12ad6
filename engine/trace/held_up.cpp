#include "engine/trace/held_up.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <string_view>

namespace weft::engine {
namespace {

/// Of the thread that opens it.
class SchedulerStatistics {
 public:
  SchedulerStatistics() : file_(open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC)) {}
  ~SchedulerStatistics() {
    if (file_ >= 0) close(file_);
  }
  SchedulerStatistics(const SchedulerStatistics&) = delete;
  SchedulerStatistics& operator=(const SchedulerStatistics&) = delete;

  /// "time on a processor, time waiting for one, times that it got one".
  TimePoint waited() const {
    std::array<char, 128> line;
    const ssize_t size = file_ < 0 ? 0 : pread(file_, line.data(), line.size(), 0);
    const std::string_view text(line.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    const std::size_t space = text.find(' ');
    TimePoint waited = 0;
    if (space != text.npos) std::from_chars(text.data() + space + 1, text.data() + text.size(), waited);
    return waited;
  }

 private:
  int file_;
};

}  // namespace

TimePoint held_up() {
  thread_local const SchedulerStatistics statistics;
  return statistics.waited();
}

}  // namespace weft::engine

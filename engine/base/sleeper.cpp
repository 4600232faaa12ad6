// Sleeping and waking by the futex system call.
#include "engine/base/sleeper.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace weft::engine {
namespace {

/// Not FUTEX_PRIVATE: the word may lie in memory shared with other processes.
void futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value,
           const timespec* timeout) noexcept {
  syscall(SYS_futex, &word, operation, value, timeout, nullptr, 0);
}

}  // namespace

void Sleeper::wait(Ticket seen, std::chrono::nanoseconds timeout) noexcept {
  if (timeout <= std::chrono::nanoseconds::zero()) return;
  // Advertised before the kernel compares the word again: a ring before this line fails the exchange, one
  // after it both changes the word and sees kAsleep, so it calls wake_sleeper(). Neither can be missed.
  std::uint32_t expected = seen;
  if (word_.compare_exchange_strong(expected, seen | kAsleep, std::memory_order_acq_rel)) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
    const timespec time{seconds.count(), (timeout - seconds).count()};
    futex(word_, FUTEX_WAIT, seen | kAsleep, &time);
    // The sleeper takes its advertisement down, not the ringer: one who dies or is held up between the two
    // could otherwise leave a sleeper whom nobody wakes.
    word_.fetch_and(~kAsleep, std::memory_order_acq_rel);
  }
}

void Sleeper::wake_sleeper() noexcept {
  const int saved = errno;  // ring() may run in a signal handler
  futex(word_, FUTEX_WAKE, 1, nullptr);
  errno = saved;
}

}  // namespace weft::engine

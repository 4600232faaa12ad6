// A place where one thread sleeps until another thread, process or signal handler rings; costs nothing while
// nobody sleeps.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace weft::engine {

/// A doorbell on a futex. Works in process memory and in memory shared between processes of a node (all zero
/// bytes are a valid, never rung Sleeper). Any number may ring(), one thread waits.
class Sleeper {
 public:
  /// How often the bell has been rung, as far as wait() is concerned.
  using Ticket = std::uint32_t;

  Ticket ticket() const noexcept { return word_.load(std::memory_order_acquire) & ~kAsleep; }

  /// Ends the wait() in progress, and any later one whose ticket was drawn before. Everything written before
  /// ring() is seen after that wait(). Without a sleeper it is one atomic addition; safe in signal handlers.
  void ring() noexcept {
    if (word_.fetch_add(kRing, std::memory_order_acq_rel) & kAsleep) wake_sleeper();
  }

  /// Sleeps until the bell is rung, or has been since `seen` was drawn, or `timeout` is over. May return
  /// early.
  void wait(Ticket seen, std::chrono::nanoseconds timeout) noexcept;

 private:
  // Lowest bit: somebody sleeps, or is about to. The rest counts rings, so that the word a sleeper hands to
  // the kernel is out of date as soon as anybody rings.
  static constexpr std::uint32_t kAsleep = 1, kRing = 2;

  void wake_sleeper() noexcept;

  std::atomic<std::uint32_t> word_{0};
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free,
                "shared between processes and signal handlers");
  static_assert(sizeof(std::atomic<std::uint32_t>) == 4, "a futex is four bytes");
};

}  // namespace weft::engine

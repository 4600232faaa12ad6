// Time as a simulated rank sees it: ranks take turns on one thread, and each has a clock of its own
// (engine/simulate/).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace weft::engine {

/// The clock of one simulated rank. Nanoseconds; none ever goes back, but for what run_handler() says.
class VirtualTime {
 public:
  virtual ~VirtualTime() = default;

  /// Of the rank's communication thread; within run_handler() of the worker that runs it.
  virtual std::int64_t now() const = 0;

  /// Who runs now works for so long, on top of what is measured if anything is.
  virtual void spend(std::int64_t nanoseconds) = 0;

  /// Who runs now has packed or unpacked so many bytes: time passes where none is measured.
  virtual void copied(std::size_t bytes) = 0;

  /// Runs a handler on a worker of the rank and returns what it takes; the clock then stands where it stood.
  virtual std::int64_t run_handler(const std::function<void()>& handler) = 0;

  /// So many workers more run from now on, or fewer.
  virtual void workers_run(int more) = 0;
  /// What a worker that runs all the time has worked by `time`: just that, unless ranks share cores.
  virtual std::int64_t worked(std::int64_t time) const = 0;
  /// When it has worked so much, as things are.
  virtual std::int64_t when(std::int64_t worked) const = 0;

  /// Whether the communication thread has a core: where ranks share them, one that wakes may have to wait.
  virtual bool communicates() const = 0;

  /// What the communication thread has worked so far.
  virtual std::int64_t communicated() const = 0;

  /// That of the rank whose turn it is; null on a thread that simulates none.
  static VirtualTime* of_thread() { return of_thread_; }

 protected:
  static inline constinit thread_local VirtualTime* of_thread_ = nullptr;
};

}  // namespace weft::engine

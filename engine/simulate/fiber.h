// A function with a stack of its own that is left and gone on with: a simulated rank waits in the middle of
// whatever it does.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace weft::engine {

/// All functions are called on one thread. Exceptions may be handled on either side of a switch; one that
/// leaves the function ends the process. Signal mask and rounding mode are the thread's, not the function's.
class Fiber {
 public:
  /// The stack is reserved, and takes memory as far as it is used. Throws std::bad_alloc.
  Fiber(std::size_t stack_bytes, std::function<void()> function);
  /// One that has not finished is forgotten: what its stack holds is not destroyed.
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// From outside: goes on with the function until it leaves or returns.
  void enter();
  /// From inside: back to who has entered.
  void leave();
  bool finished() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::engine

// How work ends that is interrupted before it has a mesh.
#pragma once

#include <atomic>
#include <exception>

namespace weft::meshing {

/// What there is by then is of no use to anybody.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted before there was a mesh"; }
};

/// Throws Interrupted once the flag, if any, is set.
inline void check_interrupt(const std::atomic<bool>* flag) {
  if (flag != nullptr && flag->load(std::memory_order_relaxed)) throw Interrupted();
}

}  // namespace weft::meshing

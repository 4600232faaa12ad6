// Address space that is kept for the end of what may run out of memory.
#pragma once

#include <sys/mman.h>

#include <cstddef>

namespace weft::meshing {

/// Takes address space and no memory until it is released; where there is less (ulimit -v), a quarter to a
/// half of that. Large arrays reserve all that they find: without it what comes after them would find none.
class SpareAddressSpace {
 public:
  explicit SpareAddressSpace(std::size_t bytes) : bytes_(bytes) {
    take();
    if (at_ != MAP_FAILED) return;
    while (at_ == MAP_FAILED && bytes_ > kLeast) {
      bytes_ /= 2;
      take();
    }
    release();
    bytes_ /= 2;
    take();
  }
  SpareAddressSpace(const SpareAddressSpace&) = delete;
  SpareAddressSpace& operator=(const SpareAddressSpace&) = delete;
  ~SpareAddressSpace() { release(); }

  void release() {
    if (at_ != MAP_FAILED) munmap(at_, bytes_);
    at_ = MAP_FAILED;
  }

 private:
  static constexpr std::size_t kLeast = std::size_t{1} << 20;

  void take() { at_ = mmap(nullptr, bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0); }

  std::size_t bytes_;
  void* at_ = MAP_FAILED;
};

}  // namespace weft::meshing

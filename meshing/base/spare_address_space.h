// Address space that is kept for the end of what may run out of memory.
#pragma once

#include <sys/mman.h>

#include <cstddef>

namespace weft::meshing {

/// Takes address space and no memory, as far as there is some (ulimit -v), until it is released. Large arrays
/// reserve all that they find: without it what comes after them would find none.
class SpareAddressSpace {
 public:
  explicit SpareAddressSpace(std::size_t bytes)
      : bytes_(bytes),
        at_(mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)) {}
  SpareAddressSpace(const SpareAddressSpace&) = delete;
  SpareAddressSpace& operator=(const SpareAddressSpace&) = delete;
  ~SpareAddressSpace() { release(); }

  void release() {
    if (at_ != MAP_FAILED) munmap(at_, bytes_);
    at_ = MAP_FAILED;
  }

 private:
  std::size_t bytes_;
  void* at_;
};

}  // namespace weft::meshing

// Memory of large blocks, recycled: the first touch of fresh pages costs several times what copying a message
// into them does (measured: 1.7 GB/s into fresh pages, 8 to 12 into used ones; tbbmalloc gives blocks of 64
// MiB back at once).
#include "engine/base/blob.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <new>

#include "engine/base/blob_pool.h"

namespace weft::engine {
namespace {

constexpr std::size_t kLine = 64;
constexpr std::size_t kLarge = std::size_t{1} << 18;     ///< malloc recycles smaller blocks well
constexpr std::size_t kHugePage = std::size_t{1} << 21;  ///< touching fresh huge pages is three times as fast
#if defined(__SANITIZE_ADDRESS__)
constexpr std::size_t kMostKept = 0;  ///< a recycled block would hide a use after free
#else
constexpr std::size_t kMostKept = std::size_t{1} << 24;  ///< messages of several neighbours; it is memory
#endif

/// In front of every block, since whoever frees it knows its address only. A cache line, to keep the data
/// aligned.
struct alignas(kLine) Header {
  std::size_t bytes;  ///< of the whole block
};

/// Sizes are rounded up by an eighth at most, so that a block fits the next request of about its size.
std::size_t rounded(std::size_t bytes) {
  const std::size_t step = std::max(std::bit_floor(bytes) / 8, kLine);
  return (bytes + step - 1) / step * step;
}

void* fresh(std::size_t bytes) {
  const bool huge = bytes >= 2 * kHugePage;
  void* block = std::aligned_alloc(huge ? kHugePage : kLine, bytes);
  if (!block) throw std::bad_alloc();
  if (huge) madvise(block, bytes, MADV_HUGEPAGE);  // advice: no harm where it is not taken
  return block;
}

/// Freed large blocks, the latest last; the oldest go when all together are more than kMostKept.
class Pool {
 public:
  /// With room for all that it may ever keep: give() must not fail.
  Pool() { kept_.reserve(kMostKept / kLarge); }

  /// A block of exactly `bytes`, or null.
  void* take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = kept_.size(); i-- > 0;) {  // the latest is the one most likely still in the caches
      if (kept_[i].bytes != bytes) continue;
      void* block = kept_[i].block;
      kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(i));
      total_ -= bytes;
      return block;
    }
    return nullptr;
  }

  void clear() {
    const std::lock_guard lock(mutex_);
    for (const Kept& kept : kept_) std::free(kept.block);
    kept_.clear();
    total_ = 0;
  }

  void give(void* block, std::size_t bytes) noexcept {
    if (bytes > kMostKept) return std::free(block);
    const std::lock_guard lock(mutex_);
    std::size_t gone = 0;
    for (; total_ + bytes > kMostKept; ++gone) {
      std::free(kept_[gone].block);
      total_ -= kept_[gone].bytes;
    }
    kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(gone));
    kept_.push_back({block, bytes});
    total_ += bytes;
  }

 private:
  struct Kept {
    void* block;
    std::size_t bytes;
  };

  std::mutex mutex_;
  std::vector<Kept> kept_;
  std::size_t total_ = 0;
};

/// Never destroyed: blobs may be freed while the program ends.
Pool& pool() {
  static Pool& instance = *new Pool;
  return instance;
}

void release(void* block) {
  const std::size_t bytes = static_cast<Header*>(block)->bytes;
  if (bytes < kLarge) return std::free(block);
  pool().give(block, bytes);
}

}  // namespace

void give_back_freed_blobs() { pool().clear(); }

Blob Blob::allocate(std::size_t size) {
  if (size > std::numeric_limits<std::ptrdiff_t>::max() / 2) throw std::bad_alloc();
  const std::size_t bytes = sizeof(Header) + rounded(size);
  void* block = bytes < kLarge ? nullptr : pool().take(bytes);
  if (!block) block = fresh(bytes);
  auto* header = new (block) Header{bytes};
  Blob blob;
  blob.holder_ = Holder(block, release);
  blob.data_ = reinterpret_cast<std::byte*>(header + 1);
  blob.size_ = size;
  return blob;
}

}  // namespace weft::engine

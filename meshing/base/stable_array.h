// An array that fills without moving: address space is reserved, pages come when touched.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <type_traits>
#include <utility>

namespace weft::meshing {

/// Huge pages (2 MiB) serve large arrays; small ones would waste most of theirs.
enum class Pages { small, huge };

/// The system does not grant the address space that an array reserves.
class NoAddressSpace : public std::bad_alloc {
 public:
  const char* what() const noexcept override {
    return "cannot reserve address space for the mesh: is it limited (ulimit -v, vm.overcommit_memory = 2)?";
  }
};

/// Zero-initialised storage for up to `capacity` elements of a plain type. Only pages that are touched cost
/// memory, so that readers keep valid references while other threads append.
template <class T>
class StableArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit StableArray(std::size_t capacity, Pages pages = Pages::huge) : bytes_(capacity * sizeof(T)) {
    void* p =
        mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (p == MAP_FAILED) throw NoAddressSpace();
    // Random access over hundreds of megabytes is bound by the TLB without huge pages.
    madvise(p, bytes_, pages == Pages::huge ? MADV_HUGEPAGE : MADV_NOHUGEPAGE);
    data_ = static_cast<T*>(p);
  }
  ~StableArray() {
    if (data_) munmap(data_, bytes_);
  }
  StableArray(StableArray&& o) noexcept
      : data_(std::exchange(o.data_, nullptr)), bytes_(std::exchange(o.bytes_, 0)) {}
  StableArray& operator=(StableArray&& o) noexcept {
    std::swap(data_, o.data_);
    std::swap(bytes_, o.bytes_);
    return *this;
  }

  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::size_t capacity() const { return bytes_ / sizeof(T); }

  /// Room for `capacity` elements; what there was beyond is lost. The others may move: nobody else may have
  /// the array. Throws NoAddressSpace, never for less than there is.
  void set_capacity(std::size_t capacity) {
    const std::size_t bytes = capacity * sizeof(T);
    if (bytes == bytes_) return;
    void* p = mremap(data_, bytes_, bytes, MREMAP_MAYMOVE);
    if (p == MAP_FAILED) throw NoAddressSpace();
    data_ = static_cast<T*>(p);
    bytes_ = bytes;
  }

  /// Elements `size` to `used` read as zero again; those behind have not been touched. Their memory goes back
  /// to the system where it is more than a quarter of what was used: to be given a page again takes longer
  /// than to clear it, and most arrays grow on.
  void clear_from(std::size_t size, std::size_t used) {
    constexpr std::size_t kPage = 4096;
    if (size >= used) return;
    char* const bytes = reinterpret_cast<char*>(data_);
    std::size_t clear_to = used * sizeof(T);
    if (used - size > used / 4) {
      const std::size_t first_page = (size * sizeof(T) + kPage - 1) / kPage * kPage;
      if (first_page < clear_to) madvise(bytes + first_page, clear_to - first_page, MADV_DONTNEED);
      clear_to = std::min(clear_to, first_page);
    }
    std::memset(bytes + size * sizeof(T), 0, clear_to - size * sizeof(T));
  }

 private:
  T* data_ = nullptr;
  std::size_t bytes_ = 0;
};

}  // namespace weft::meshing

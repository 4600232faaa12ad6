// A table by rank of which few entries are used: a run of ten thousand ranks must not cost each of them
// ten thousand entries of everything.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace weft::engine {

/// Entries are made, by pages, when one is first asked for, and stay where they are.
template <class T>
class PagedTable {
 public:
  explicit PagedTable(std::size_t size) : size_(size) {}

  std::size_t size() const { return size_; }

  /// `index` < size().
  T& operator[](std::size_t index) {
    if (pages_.empty()) pages_.resize((size_ + kPage - 1) / kPage);
    auto& page = pages_[index / kPage];
    if (!page) page = std::make_unique<std::array<T, kPage>>();
    return (*page)[index % kPage];
  }

  /// Null where no entry of its page was ever asked for.
  const T* find(std::size_t index) const {
    if (index / kPage >= pages_.size() || !pages_[index / kPage]) return nullptr;
    return &(*pages_[index / kPage])[index % kPage];
  }

  /// Calls visit(index, entry) for all entries that have been made, in their order.
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::size_t p = 0; p < pages_.size(); ++p) {
      if (!pages_[p]) continue;
      for (std::size_t i = 0; i < kPage && p * kPage + i < size_; ++i) visit(p * kPage + i, (*pages_[p])[i]);
    }
  }

 private:
  static constexpr std::size_t kPage = 16;
  std::size_t size_;
  std::vector<std::unique_ptr<std::array<T, kPage>>> pages_;  ///< empty until the first entry
};

/// Counters that any thread may add to; without locks.
class PagedCounters {
 public:
  explicit PagedCounters(std::size_t size)
      : pages_((size + kPage - 1) / kPage), page_(std::make_unique<std::atomic<Page*>[]>(pages_)) {}
  PagedCounters(const PagedCounters&) = delete;
  PagedCounters& operator=(const PagedCounters&) = delete;
  ~PagedCounters() {
    for (std::size_t p = 0; p < pages_; ++p) delete page_[p].load();
  }

  /// Returns what it was before.
  std::uint64_t add(std::size_t index, std::uint64_t amount) {
    return page_of(index)[index % kPage].fetch_add(amount);
  }
  /// Sets it to 0 and returns what it was.
  std::uint64_t take(std::size_t index) {
    Page* page = page_[index / kPage].load(std::memory_order_acquire);
    return page == nullptr ? 0 : (*page)[index % kPage].exchange(0);
  }
  /// Calls visit(index) for all counters of at least `least` > 0, in their order.
  template <class Visit>
  void each_from(std::uint64_t least, const Visit& visit) const {
    for (std::size_t p = 0; p < pages_; ++p) {
      const Page* page = page_[p].load(std::memory_order_acquire);
      if (page == nullptr) continue;
      for (std::size_t i = 0; i < kPage; ++i)
        if ((*page)[i].load() >= least) visit(p * kPage + i);
    }
  }

 private:
  static constexpr std::size_t kPage = 16;
  using Page = std::array<std::atomic<std::uint64_t>, kPage>;

  Page& page_of(std::size_t index) {
    std::atomic<Page*>& place = page_[index / kPage];
    Page* page = place.load(std::memory_order_acquire);
    if (page != nullptr) return *page;
    auto made = std::make_unique<Page>();
    if (place.compare_exchange_strong(page, made.get(), std::memory_order_acq_rel)) return *made.release();
    return *page;  // another thread was faster
  }

  std::size_t pages_;
  std::unique_ptr<std::atomic<Page*>[]> page_;
};

}  // namespace weft::engine

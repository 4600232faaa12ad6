// A set of 32-bit keys for the scratch of operators.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace weft::meshing {

/// A small set of 32-bit keys that is emptied in O(1). It starts at 4 KiB, to stay in the first-level cache,
/// and grows when a neighbourhood is large.
class SmallSet {
 public:
  SmallSet() { grow(9); }
  void clear() {
    ++stamp_;
    size_ = 0;
  }
  /// True when the key was not there yet. In line like find(), against the compiler's estimate: as a call it
  /// takes twice the time.
  [[gnu::always_inline]] bool insert(std::uint32_t key) {
    Slot* s = find(key);
    const bool is_new = s->stamp != stamp_;  // no branch on it: it cannot be predicted
    *s = {key, stamp_};
    size_ += is_new;
    if (2 * size_ > slots_.size()) grow(bits_ + 1);
    return is_new;
  }
  bool contains(std::uint32_t key) const { return const_cast<SmallSet*>(this)->find(key)->stamp == stamp_; }

 private:
  struct Slot {
    std::uint32_t key = 0, stamp = 0;
  };

  /// The slot that holds the key, or the free one where it belongs.
  [[gnu::always_inline]] Slot* find(std::uint32_t key) {
    std::uint32_t i = (key * 2654435761u) >> (32 - bits_);
    // One condition, which rarely holds; whether a slot is free could not be predicted.
    while (int{slots_[i].stamp == stamp_} & int{slots_[i].key != key}) i = (i + 1) & mask_;
    return &slots_[i];
  }

  [[gnu::noinline]] void grow(int bits) {
    const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(std::size_t{1} << bits));
    bits_ = bits;
    mask_ = (1u << bits) - 1;
    for (const Slot& s : old)
      if (s.stamp == stamp_) *find(s.key) = s;
  }

  std::vector<Slot> slots_;
  std::uint32_t stamp_ = 1, mask_ = 0;
  std::size_t size_ = 0;
  int bits_ = 0;
};

}  // namespace weft::meshing

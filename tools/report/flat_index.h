// Numbers for things in the order in which they are first met.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace weft::report {

/// Keys of kSize integers. A hash table with open addressing and no erasure: std::unordered_map takes five
/// times as long here, and std::map fifteen times.
template <class Integer, std::size_t kSize>
class FlatIndex {
 public:
  using Key = std::array<Integer, kSize>;

  /// `expected`: how many keys there may be; more are taken, too.
  explicit FlatIndex(std::size_t expected) {
    std::size_t places = 16;
    while (places < 2 * expected) places *= 2;
    places_.assign(places, kEmpty);
  }

  /// The number of `key`: size() before the call if it had none.
  std::uint32_t number_of(const Key& key) {
    if (2 * keys_.size() >= places_.size()) grow();
    const std::size_t place = place_of(key);
    if (places_[place] == kEmpty) {
      places_[place] = static_cast<std::uint32_t>(keys_.size());
      keys_.push_back(key);
    }
    return places_[place];
  }
  std::size_t size() const { return keys_.size(); }

 private:
  static constexpr std::uint32_t kEmpty = std::numeric_limits<std::uint32_t>::max();

  /// By multiplication with an odd constant (Fibonacci hashing; Knuth, vol. 3, 6.4): the high bits are good.
  static std::size_t hash(const Key& key) {
    constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15u;
    std::uint64_t hash = 0;
    for (const Integer i : key) hash = (hash ^ (hash >> 32) ^ static_cast<std::uint64_t>(i)) * kGolden;
    return static_cast<std::size_t>(hash >> 32);
  }
  /// The operator of std::array calls memcmp for a dozen bytes.
  static bool equal(const Key& a, const Key& b) {
    bool same = true;
    for (std::size_t i = 0; i < kSize; ++i) same &= a[i] == b[i];
    return same;
  }
  /// Where the key is or would be.
  std::size_t place_of(const Key& key) const {
    const std::size_t mask = places_.size() - 1;
    std::size_t place = hash(key) & mask;
    while (places_[place] != kEmpty && !equal(keys_[places_[place]], key)) place = (place + 1) & mask;
    return place;
  }
  void grow() {
    places_.assign(2 * places_.size(), kEmpty);
    for (std::uint32_t i = 0; i < keys_.size(); ++i) places_[place_of(keys_[i])] = i;
  }

  std::vector<std::uint32_t> places_;  // a power of two of them
  std::vector<Key> keys_;
};

}  // namespace weft::report

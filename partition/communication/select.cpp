// From the highest byte to the lowest: a histogram of all ranks says in which 1/256 the value lies, until few
// are left.
#include "partition/communication/select.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

#include "meshing/base/parallel.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

constexpr std::uint64_t kSign = std::uint64_t{1} << 63;

/// Unsigned numbers in the order of the doubles.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return bits & kSign ? ~bits : bits | kSign;
}
double value_of(std::uint64_t key) { return std::bit_cast<double>(key & kSign ? key & ~kSign : ~key); }

/// The key at a place, as far as it is known, and this rank's keys that begin like it. They are copied once
/// they are few: the first byte of values of a kind is the same for nearly all.
class Search {
 public:
  Search(std::span<const std::span<const double>> lists, std::uint64_t place) : lists_(lists), place_(place) {
    for (const std::span<const double> list : lists) num_values_ += list.size();
  }

  std::uint64_t found() const { return found_; }

  /// How many of this rank's keys have each value of the byte at `shift`: 256 counts.
  void count(int shift, std::uint64_t* counts) const {
    const auto byte_of = [&](std::uint64_t key) { return key >> shift & 0xFF; };
    if (are_copied_) {
      for (const std::uint64_t key : keys_) ++counts[byte_of(key)];
      return;
    }
    std::vector<std::array<std::uint64_t, 256>> of_lists(lists_.size());
    meshing::for_each_large(lists_.size(), [&](std::size_t i) {
      of_lists[i] = {};
      for_each_key_of(lists_[i], shift, [&](std::uint64_t key) { ++of_lists[i][byte_of(key)]; });
    });
    for (const auto& of_list : of_lists)
      for (std::size_t byte = 0; byte < of_list.size(); ++byte) counts[byte] += of_list[byte];
  }

  /// Goes into the byte in which the place is, by the counts of all ranks. `mine`: those of this one.
  void narrow(int shift, const std::uint64_t* counts, const std::uint64_t* mine) {
    constexpr std::size_t kFew = 4;  // a quarter of the values
    std::uint64_t byte = 0;
    for (; place_ >= counts[byte] && byte < 255; ++byte) place_ -= counts[byte];
    std::vector<std::uint64_t> keys;
    const bool copies = are_copied_ || kFew * mine[byte] <= num_values_;
    if (copies) {
      keys.reserve(mine[byte]);
      for_each_key(shift, [&](std::uint64_t key) {
        if ((key >> shift & 0xFF) == byte) keys.push_back(key);
      });
      keys_ = std::move(keys);
      are_copied_ = true;
    }
    found_ |= byte << shift;
    left_ = counts[byte];
  }

  /// Keys of all ranks that begin as what is found.
  std::uint64_t left() const { return left_; }
  /// Those of this rank; the byte at `shift` was the last that narrow() has seen.
  void append_keys(int shift, std::vector<std::uint64_t>& keys) const {
    for_each_key(shift, [&](std::uint64_t key) {
      if (key >> shift == found_ >> shift) keys.push_back(key);
    });
  }
  /// `keys`: those of all ranks. Puts them in order.
  void find_among(std::span<std::uint64_t> keys) {
    const auto at = keys.begin() + static_cast<std::ptrdiff_t>(place_);
    std::ranges::nth_element(keys, at);
    found_ = *at;
  }

 private:
  /// Those that begin as what is found, to above the byte at `shift`.
  template <class F>
  void for_each_key(int shift, const F& f) const {
    for (const std::uint64_t key : keys_) f(key);
    if (are_copied_) return;
    for (const std::span<const double> list : lists_) for_each_key_of(list, shift, f);
  }
  template <class F>
  void for_each_key_of(std::span<const double> list, int shift, const F& f) const {
    for (const double value : list)
      if (const std::uint64_t key = key_of(value); (key ^ found_) >> shift <= 0xFF) f(key);
  }

  std::span<const std::span<const double>> lists_;
  std::size_t num_values_ = 0;
  std::vector<std::uint64_t> keys_;
  bool are_copied_ = false;
  std::uint64_t place_, found_ = 0, left_ = 0;
};

/// So many keys are sent in place of another histogram.
bool are_few(std::span<const Search> searches) {
  constexpr std::uint64_t kFew = 256;
  std::uint64_t left = 0;
  for (const Search& search : searches) left += search.left();
  return left <= kFew * searches.size();
}

/// All ranks get all keys that are left.
void finish(Peers& peers, int shift, std::span<Search> searches) {
  struct KeyLeft {
    std::uint64_t search, key;
  };
  std::vector<KeyLeft> mine;
  for (std::uint64_t s = 0; s < searches.size(); ++s) {
    std::vector<std::uint64_t> keys;
    searches[s].append_keys(shift, keys);
    for (const std::uint64_t key : keys) mine.push_back({s, key});
  }
  std::vector<std::vector<std::uint64_t>> keys(searches.size());
  for (const KeyLeft& candidate : allgather_joined(peers, mine))
    keys[candidate.search].push_back(candidate.key);
  for (std::size_t s = 0; s < searches.size(); ++s) searches[s].find_among(keys[s]);
}

}  // namespace

std::vector<std::vector<double>> select_each(Peers& peers, std::span<const Selection> selections) {
  std::vector<Search> searches;
  for (const Selection& wanted : selections)
    for (const std::uint64_t place : wanted.places) searches.emplace_back(wanted.lists, place);
  if (searches.empty()) return std::vector<std::vector<double>>(selections.size());
  int shift = 56;
  do {
    std::vector<std::uint64_t> mine(256 * searches.size());
    for (std::size_t s = 0; s < searches.size(); ++s) searches[s].count(shift, mine.data() + 256 * s);
    const std::vector<std::uint64_t> counts = partition::sum(peers, mine);
    for (std::size_t s = 0; s < searches.size(); ++s)
      searches[s].narrow(shift, counts.data() + 256 * s, mine.data() + 256 * s);
    shift -= 8;
  } while (shift >= 0 && !are_few(searches));
  if (shift >= 0) finish(peers, shift + 8, searches);
  std::vector<std::vector<double>> found;
  auto next = searches.begin();
  for (const Selection& wanted : selections) {
    std::vector<double>& values = found.emplace_back();
    for (std::size_t i = 0; i < wanted.places.size(); ++i) values.push_back(value_of(next++->found()));
  }
  return found;
}

std::vector<double> select(Peers& peers, std::span<const double> values,
                           std::span<const std::uint64_t> places) {
  const Selection wanted{{values}, places};
  return select_each(peers, std::span(&wanted, 1))[0];
}

}  // namespace weft::partition

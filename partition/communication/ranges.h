// Arrays cut into one contiguous range a rank, and fetching from them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/release.h"
#include "partition/communication/even_shares.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// Rank r has the entries with numbers first(r) to first(r + 1) - 1.
class Ranges {
 public:
  /// From the number of entries here; all ranks call together.
  Ranges(Peers& peers, std::uint64_t my_count) : Ranges(of_arrays(peers, {my_count})[0]) {}
  /// Of several arrays, in one exchange.
  static std::vector<Ranges> of_arrays(Peers& peers, const std::vector<std::uint64_t>& my_counts) {
    std::vector<Ranges> arrays(my_counts.size(), Ranges());
    std::size_t i = 0;
    for (const std::uint64_t count : allgather_joined(peers, my_counts)) {
      std::vector<std::uint64_t>& firsts = arrays[i++ % arrays.size()].firsts_;
      firsts.push_back(firsts.back() + count);
    }
    return arrays;
  }
  std::uint64_t first(int rank) const { return firsts_[static_cast<std::size_t>(rank)]; }
  std::uint64_t total() const { return firsts_.back(); }
  /// The rank that has entry `number`, below total().
  std::size_t rank_of(std::uint64_t number) const {
    return static_cast<std::size_t>(std::upper_bound(firsts_.begin(), firsts_.end(), number) -
                                    firsts_.begin()) -
           1;
  }

 private:
  Ranges() = default;

  std::vector<std::uint64_t> firsts_ = {0};
};

/// All ranks: the same entries in the same order, of which each rank gets an equal share.
template <class T>
std::vector<T> dealt_evenly(Peers& peers, const std::vector<T>& mine) {
  const Ranges ranges(peers, mine.size());
  const EvenShares shares(ranges.total(), peers.ranks());
  const std::uint64_t first = ranges.first(peers.rank()), last = first + mine.size();
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::uint64_t r = 0; r < to_each.size(); ++r) {
    const std::uint64_t begin = std::clamp(shares.first(r), first, last);
    const std::uint64_t end = std::clamp(shares.first(r + 1), first, last);
    to_each[r].assign(mine.begin() + static_cast<std::ptrdiff_t>(begin - first),
                      mine.begin() + static_cast<std::ptrdiff_t>(end - first));
  }
  return all_to_all_joined(peers, std::move(to_each));
}

/// All ranks: the numbers of entries that each rank has sent to this one, whose entries they are.
template <class Number>
std::vector<std::vector<Number>> sent_to_owners(Peers& peers, const Ranges& ranges,
                                                const std::vector<Number>& numbers) {
  std::vector<std::vector<Number>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const Number number : numbers) to_each[ranges.rank_of(number)].push_back(number);
  return partition::all_to_all(peers, std::move(to_each));
}

/// The entries of these numbers (ascending) from the ranks that have them. `entry(i)` is entry i of this
/// rank's range; all ranks call together.
template <class T, class Number, class Entry>
std::vector<T> fetch(Peers& peers, const Ranges& ranges, const std::vector<Number>& numbers,
                     const Entry& entry) {
  std::vector<std::vector<Number>> wanted = sent_to_owners(peers, ranges, numbers);
  std::vector<std::vector<T>> replies(wanted.size());
  for (std::size_t r = 0; r < wanted.size(); ++r) {
    replies[r].reserve(wanted[r].size());
    for (const Number number : wanted[r])
      replies[r].push_back(entry(static_cast<std::size_t>(number - ranges.first(peers.rank()))));
    meshing::release(wanted[r]);
  }
  // Ranges ascend with the ranks, and so do the numbers: the replies are in order one after the other.
  return all_to_all_joined(peers, std::move(replies));
}

}  // namespace weft::partition

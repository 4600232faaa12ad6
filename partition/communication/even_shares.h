// Numbered things in shares that differ by at most one, in the order of the ranks.
#pragma once

#include <cstddef>
#include <cstdint>

namespace weft::partition {

/// Numbers from 0 to total - 1: rank r has those from first(r) to first(r + 1) - 1. total * ranks < 2^64.
class EvenShares {
 public:
  EvenShares(std::uint64_t total, int ranks) : total_(total), ranks_(static_cast<std::uint64_t>(ranks)) {}

  std::uint64_t first(std::uint64_t rank) const { return total_ * rank / ranks_; }
  std::uint64_t first(int rank) const { return first(static_cast<std::uint64_t>(rank)); }
  std::uint64_t count(int rank) const { return first(rank + 1) - first(rank); }
  /// The rank that has a number below total.
  std::size_t rank_of(std::uint64_t number) const { return ((number + 1) * ranks_ - 1) / total_; }

 private:
  std::uint64_t total_, ranks_;
};

}  // namespace weft::partition

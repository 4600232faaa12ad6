// Sums and extremes over all ranks, the same bits for any number of ranks.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// Element by element combine(a, b) over the arrays of all ranks, which must be of one length; every rank
/// gets the result. Short arrays are combined over the tree of Peers::reduce; of long ones each rank combines
/// one block for all. The result is independent of the number of ranks where `combine` is exactly associative
/// and commutative: integer sums, extremes.
template <class T, class Combine>
std::vector<T> reduce(Peers& peers, const std::vector<T>& mine, const Combine& combine) {
  constexpr std::size_t kLongBytes = 1 << 12;
  if (mine.size() * sizeof(T) < kLongBytes) {
    return values_of<T>(peers.reduce(bytes_of(mine), [&](Bytes& sum, const Bytes& more) {
      std::vector<T> values = values_of<T>(sum);
      const std::vector<T> others = values_of<T>(more);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = combine(values[i], others.at(i));
      sum = bytes_of(values);
    }));
  }
  const auto ranks = static_cast<std::size_t>(peers.ranks());
  std::vector<std::vector<T>> blocks(ranks);
  for (std::size_t r = 0; r < ranks; ++r)
    blocks[r].assign(mine.begin() + mine.size() * r / ranks, mine.begin() + mine.size() * (r + 1) / ranks);
  blocks = partition::all_to_all(peers, blocks);
  std::vector<T> block = std::move(blocks[0]);
  for (std::size_t r = 1; r < ranks; ++r)
    for (std::size_t i = 0; i < block.size(); ++i) block[i] = combine(block[i], blocks[r][i]);
  std::vector<T> result;
  result.reserve(mine.size());
  for (const std::vector<T>& part : allgather(peers, block))
    result.insert(result.end(), part.begin(), part.end());
  return result;
}

/// Sums over all ranks. T is an integer type: floating-point sums would depend on the number of ranks.
template <class T>
std::vector<T> sum(Peers& peers, const std::vector<T>& mine) {
  static_assert(std::is_integral_v<T>);
  return reduce(peers, mine, [](T a, T b) { return static_cast<T>(a + b); });
}
template <class T>
T sum(Peers& peers, T mine) {
  return sum(peers, std::vector<T>{mine})[0];
}
template <class T>
std::vector<T> max(Peers& peers, const std::vector<T>& mine) {
  return reduce(peers, mine, [](T a, T b) { return a < b ? b : a; });
}
template <class T>
T max(Peers& peers, T mine) {
  return max(peers, std::vector<T>{mine})[0];
}

/// Sum of all ranks' values, each finite and at least 0, to 2^-52 of the greatest for each: the sum is of
/// integers, and the same bits in any order.
double ordered_sum(Peers& peers, std::span<const double> values);

}  // namespace weft::partition

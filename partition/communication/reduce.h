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
/// gets the result. The result is independent of the number of ranks where `combine` is exactly associative
/// and commutative: integer sums, extremes.
template <class T, class Combine>
std::vector<T> reduce(Peers& peers, const std::vector<T>& mine, const Combine& combine) {
  return values_of<T>(peers.reduce(bytes_of(mine), [&](Bytes& sum, const Bytes& more) {
    std::vector<T> values = values_of<T>(sum);
    const std::vector<T> others = values_of<T>(more);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = combine(values[i], others.at(i));
    sum = bytes_of(values);
  }));
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
template <class T>
std::vector<T> min(Peers& peers, const std::vector<T>& mine) {
  return reduce(peers, mine, [](T a, T b) { return b < a ? b : a; });
}

/// By T::add, which must be exactly associative and commutative.
template <class T>
std::vector<T> added(Peers& peers, const std::vector<T>& mine) {
  return reduce(peers, mine, [](T a, const T& b) {
    a.add(b);
    return a;
  });
}

/// Sum of all ranks' values, each finite and at least 0, to 2^-52 of the greatest for each: the sum is of
/// integers, and the same bits in any order.
double ordered_sum(Peers& peers, std::span<const double> values);
/// Of several lists at once, in as many exchanges as of one.
std::vector<double> ordered_sums(Peers& peers, std::span<const std::span<const double>> lists);

}  // namespace weft::partition

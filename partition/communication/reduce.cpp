// The one reduction of floating-point numbers, by way of integers.
#include "partition/communication/reduce.h"

#include <algorithm>
#include <cmath>

namespace weft::partition {

std::vector<double> ordered_sums(Peers& peers, std::span<const std::span<const double>> lists) {
  std::vector<double> greatest(lists.size(), 0);
  for (std::size_t i = 0; i < lists.size(); ++i)
    for (const double value : lists[i]) greatest[i] = std::max(greatest[i], value);
  greatest = partition::max(peers, greatest);
  // In units of 2^-62 of the power of two above the greatest, in two halves that 2^32 values cannot overflow.
  std::vector<int> exponents(lists.size(), 0);
  std::vector<std::uint64_t> halves(2 * lists.size(), 0);
  for (std::size_t i = 0; i < lists.size(); ++i) {
    if (greatest[i] == 0) continue;
    std::frexp(greatest[i], &exponents[i]);
    for (const double value : lists[i]) {
      const auto units = static_cast<std::uint64_t>(std::ldexp(value, 62 - exponents[i]));
      halves[2 * i] += units & 0xFFFFFFFFu;
      halves[2 * i + 1] += units >> 32;
    }
  }
  std::vector<double> sums(lists.size(), 0);
  if (std::ranges::all_of(greatest, [](double g) { return g == 0; })) return sums;
  halves = partition::sum(peers, halves);
  for (std::size_t i = 0; i < lists.size(); ++i)
    sums[i] = std::ldexp(static_cast<double>(halves[2 * i]), exponents[i] - 62) +
              std::ldexp(static_cast<double>(halves[2 * i + 1]), exponents[i] - 30);
  return sums;
}

double ordered_sum(Peers& peers, std::span<const double> values) {
  return ordered_sums(peers, std::span(&values, 1))[0];
}

}  // namespace weft::partition

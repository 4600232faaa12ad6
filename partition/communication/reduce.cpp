// The one reduction of floating-point numbers, by way of integers.
#include "partition/communication/reduce.h"

#include <algorithm>
#include <cmath>

namespace weft::partition {

double ordered_sum(Peers& peers, std::span<const double> values) {
  double greatest = 0;
  for (const double value : values) greatest = std::max(greatest, value);
  greatest = partition::max(peers, greatest);
  if (greatest == 0) return 0;
  // In units of 2^-62 of the power of two above the greatest, in two halves that 2^32 values cannot overflow.
  int exponent = 0;
  std::frexp(greatest, &exponent);
  std::vector<std::uint64_t> halves(2, 0);
  for (const double value : values) {
    const auto units = static_cast<std::uint64_t>(std::ldexp(value, 62 - exponent));
    halves[0] += units & 0xFFFFFFFFu;
    halves[1] += units >> 32;
  }
  halves = partition::sum(peers, halves);
  return std::ldexp(static_cast<double>(halves[0]), exponent - 62) +
         std::ldexp(static_cast<double>(halves[1]), exponent - 30);
}

}  // namespace weft::partition

// The one reduction of floating-point numbers, by way of integers.
#include "partition/communication/reduce.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace weft::partition {
namespace {

constexpr std::size_t kGrain = 4096;

double greatest_of(std::span<const double> values) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, values.size(), kGrain), 0.0,
      [&](const tbb::blocked_range<std::size_t>& range, double greatest) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) greatest = std::max(greatest, values[i]);
        return greatest;
      },
      [](double a, double b) { return std::max(a, b); });
}

/// A sum in two halves that 2^32 values cannot overflow.
using Halves = std::array<std::uint64_t, 2>;

/// Of the values in units of 2^-`shift`, of which each has less than 2^62.
Halves sum_of_units(std::span<const double> values, int shift) {
  // In two steps: one factor might be out of range. What underflows between them is less than a unit.
  const double first = std::ldexp(1.0, shift / 2), second = std::ldexp(1.0, shift - shift / 2);
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, values.size(), kGrain), Halves{},
      [&](const tbb::blocked_range<std::size_t>& range, Halves halves) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const auto units = static_cast<std::uint64_t>(values[i] * first * second);
          halves[0] += units & 0xFFFFFFFFu;
          halves[1] += units >> 32;
        }
        return halves;
      },
      [](const Halves& a, const Halves& b) {
        return Halves{a[0] + b[0], a[1] + b[1]};
      });
}

}  // namespace

std::vector<double> ordered_sums(Peers& peers, std::span<const std::span<const double>> lists) {
  std::vector<double> greatest;
  for (const std::span<const double> list : lists) greatest.push_back(greatest_of(list));
  greatest = partition::max(peers, greatest);
  // In units of 2^-62 of the power of two above the greatest.
  std::vector<int> exponents(lists.size(), 0);
  std::vector<std::uint64_t> halves(2 * lists.size(), 0);
  for (std::size_t i = 0; i < lists.size(); ++i) {
    if (greatest[i] == 0) continue;
    std::frexp(greatest[i], &exponents[i]);
    std::ranges::copy(sum_of_units(lists[i], 62 - exponents[i]),
                      halves.begin() + static_cast<std::ptrdiff_t>(2 * i));
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

// Sums of floating-point numbers that are the same bits in any order.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace weft::meshing {

/// The exponent of a power of two above this value, which is not negative.
inline int exponent_above(double value) {
  int exponent = 0;
  std::frexp(value, &exponent);
  return exponent;
}

/// A sum of numbers below 2^exponent in absolute value, of up to 2^34 of them: integers in units of
/// 2^(exponent - 84), in three parts, so that none of them overflows.
class FixedPointSum {
 public:
  void add(double value, int exponent) {
    double rest = std::ldexp(value, kBits - exponent);
    for (std::int64_t& part : parts_) {
      const double whole = std::trunc(rest);
      part += static_cast<std::int64_t>(whole);
      rest = std::ldexp(rest - whole, kBits);
    }
  }
  void add(const FixedPointSum& other) {
    for (std::size_t i = 0; i < parts_.size(); ++i) parts_[i] += other.parts_[i];
  }
  double value(int exponent) const {
    double sum = 0;
    for (std::size_t i = parts_.size(); i-- > 0;)
      sum += std::ldexp(static_cast<double>(parts_[i]), exponent - kBits * static_cast<int>(i + 1));
    return sum;
  }

 private:
  static constexpr int kBits = 28;
  std::array<std::int64_t, 3> parts_{};
};

}  // namespace weft::meshing

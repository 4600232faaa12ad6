// Sums of many terms of which nothing is lost.
#pragma once

#include <cmath>

namespace weft::meshing {

/// Neumaier's summation: the error does not grow with the number of terms.
struct CompensatedSum {
  double sum = 0, lost = 0;
  void add(double x) {
    const double next = sum + x;
    lost += std::abs(sum) >= std::abs(x) ? (sum - next) + x : (x - next) + sum;
    sum = next;
  }
  double value() const { return sum + lost; }
};

}  // namespace weft::meshing

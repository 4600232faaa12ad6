// Round numbers for axes.
#pragma once

#include <string>
#include <vector>

namespace weft::picture {

struct Tick {
  double value;
  std::string label;
};

/// About `count` multiples of 1, 2 or 5 times a power of ten in [lo, hi], labelled with the digits it takes
/// to tell them apart. None unless lo < hi, both finite and more than their rounding apart.
std::vector<Tick> linear_ticks(double lo, double hi, int count);
/// The powers of ten from 10^lo to 10^hi, with exponents as superscripts where the number would be long,
/// every second, third ... one where there are more than `count`.
std::vector<Tick> decade_ticks(double lo, double hi, int count);

}  // namespace weft::picture

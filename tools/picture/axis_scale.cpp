// Steps of 1, 2 and 5.
#include "tools/picture/axis_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace weft::picture {
namespace {

/// The smallest of 1, 2 and 5 times a power of ten that is not below `step`.
double round_up(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= step * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

/// As few digits as tell multiples of `step` apart; powers only for very large and small numbers.
std::string label(double value, double step, double largest) {
  if (largest >= 1e5 || largest < 1e-3) {
    const int digits = static_cast<int>(std::floor(std::log10(largest)) - std::floor(std::log10(step)));
    return fmt::format("{:.{}e}", value, std::max(digits, 0));
  }
  const int decimals = static_cast<int>(-std::floor(std::log10(step) + 1e-9));
  return fmt::format("{:.{}f}", value, std::max(decimals, 0));
}

std::string power_label(int exponent) {
  if (exponent >= -3 && exponent <= 4) return fmt::format("{:g}", std::pow(10, exponent));
  static constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[digit - '0'];
  return text;
}

}  // namespace

std::vector<Tick> linear_ticks(double lo, double hi, int count) {
  if (!(lo < hi) || !std::isfinite(hi - lo)) return {};
  const double step = round_up((hi - lo) / count);
  const double largest = std::max(std::abs(lo), std::abs(hi));
  constexpr double kMostSteps = 1e15;  // beyond 2^53 a count of steps would not change by one more
  if (largest / step > kMostSteps) return {};
  std::vector<Tick> ticks;
  constexpr double kRounding = 1e-9;
  for (double k = std::ceil(lo / step - kRounding); k <= hi / step + kRounding; ++k)
    ticks.push_back({k * step, label(k == 0 ? 0.0 : k * step, step, largest)});
  return ticks;
}

std::vector<Tick> decade_ticks(double lo, double hi, int count) {
  const int first = static_cast<int>(std::ceil(lo - 1e-9)), last = static_cast<int>(std::floor(hi + 1e-9));
  const int step = std::max(1, (last - first + count) / count);
  std::vector<Tick> ticks;
  for (int k = first; k <= last; k += step) ticks.push_back({std::pow(10, k), power_label(k)});
  return ticks;
}

}  // namespace weft::picture

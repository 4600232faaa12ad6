// The published control points.
#include "tools/picture/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace weft::picture {
namespace {

constexpr Colour hex(std::uint32_t rgb) {
  const auto part = [rgb](int shift) { return static_cast<float>((rgb >> shift) & 255u) / 255.0f; };
  return {part(16), part(8), part(0)};
}

constexpr std::array<Colour, 10> kViridis = {hex(0x440154), hex(0x482878), hex(0x3E4A89), hex(0x31688E),
                                             hex(0x26828E), hex(0x1F9E89), hex(0x35B779), hex(0x6DCD59),
                                             hex(0xB4DE2C), hex(0xFDE725)};
constexpr std::array<Colour, 11> kBlueToRed = {hex(0x053061), hex(0x2166AC), hex(0x4393C3), hex(0x92C5DE),
                                               hex(0xD1E5F0), hex(0xF7F7F7), hex(0xFDDBC7), hex(0xF4A582),
                                               hex(0xD6604D), hex(0xB2182B), hex(0x67001F)};
// Okabe and Ito's eight without black, which lines have.
constexpr std::array<Colour, 7> kCategories = {hex(0x56B4E9), hex(0xE69F00), hex(0x009E73), hex(0xF0E442),
                                               hex(0xCC79A7), hex(0x0072B2), hex(0xD55E00)};

/// `hue`, `saturation` and `value` from 0 to 1.
Colour from_hsv(double hue, double saturation, double value) {
  const auto part = [&](double shift) {
    const double ramp = std::abs(std::fmod(hue + shift, 1.0) * 6 - 3) - 1;
    return static_cast<float>(value * (1 - saturation + saturation * std::clamp(ramp, 0.0, 1.0)));
  };
  return {part(0), part(2.0 / 3), part(1.0 / 3)};
}

}  // namespace

Colour mix(const Colour& a, const Colour& b, double share) {
  const auto s = static_cast<float>(share);
  return {a.red + s * (b.red - a.red), a.green + s * (b.green - a.green), a.blue + s * (b.blue - a.blue)};
}

std::span<const Colour> viridis() { return kViridis; }
std::span<const Colour> blue_to_red() { return kBlueToRed; }

Colour category_colour(std::size_t i) {
  if (i < kCategories.size()) return kCategories[i];
  // The golden ratio spreads any number of hues; three strengths tell those apart that come close.
  const auto k = static_cast<double>(i - kCategories.size());
  const double strength = 0.35 + 0.2 * std::fmod(k, 3.0);
  return from_hsv(std::fmod(0.11 + k * 0.6180339887498949, 1.0), strength, 1.05 - 0.4 * strength);
}

double ColourScale::place(double value) const {
  return kind == Kind::logarithmic ? std::log(value / lo) / std::log(hi / lo) : (value - lo) / (hi - lo);
}

Colour ColourScale::colour(double value) const {
  if (std::isnan(value) || colours.empty()) return missing;
  const auto last = static_cast<double>(colours.size() - 1);
  if (kind == Kind::discrete) return colours[static_cast<std::size_t>(std::clamp(value, 0.0, last))];
  const double share = hi > lo ? std::clamp(place(value), 0.0, 1.0) : 0.5;
  const double at = share * last;
  const auto below = static_cast<std::size_t>(std::min(at, last - 1));
  return mix(colours[below], colours[below + 1], at - static_cast<double>(below));
}

const Theme& light_theme() {
  static constexpr Theme theme = {hex(0xFFFFFF), hex(0x1A1A1A), hex(0x14181F), hex(0xB9CDE0),
                                  hex(0xF2DEB0), hex(0xDDE1E6), hex(0xD7191C)};
  return theme;
}

const Theme& dark_theme() {
  static constexpr Theme theme = {hex(0x15181E), hex(0xE6E6E6), hex(0x0B0D11), hex(0x7E9DBD),
                                  hex(0xD8BE82), hex(0x98A1AC), hex(0xE8312F)};
  return theme;
}

}  // namespace weft::picture

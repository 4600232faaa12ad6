// Colours, and the scales that turn values into them: perceptually uniform or colour-blind safe ones only.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace weft::picture {

/// An opaque sRGB colour, each part from 0 to 1.
struct Colour {
  float red = 0, green = 0, blue = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// `a` where share is 0, `b` where it is 1.
Colour mix(const Colour& a, const Colour& b, double share);

/// Sequential: viridis (Smith and van der Walt, 2015), its ten evenly spaced colours.
std::span<const Colour> viridis();
/// Diverging, from blue over nearly white to red: RdBu of ColorBrewer (Brewer, 2003), reversed.
std::span<const Colour> blue_to_red();
/// The i-th colour for things without an order: those of Okabe and Ito (2008), then more hues, none repeated
/// soon.
Colour category_colour(std::size_t i);

/// What colours mean. A continuous scale runs through `colours`, evenly from `lo` to `hi`, values beyond take
/// the ends; a discrete one has the colour of value i at place i.
struct ColourScale {
  enum class Kind { linear, logarithmic, discrete };
  Kind kind = Kind::linear;
  double lo = 0, hi = 1;
  std::vector<Colour> colours;
  Colour missing;  ///< of NaN: things that have no value

  Colour colour(double value) const;
  /// Where a value lies on a continuous scale: 0 at lo, 1 at hi, not limited.
  double place(double value) const;
};

/// Whether the picture is on paper or on a screen at night.
struct Theme {
  Colour background, text, line;
  Colour surface;     ///< faces of the boundary that have no colour of their own
  Colour inside;      ///< faces that a cut has laid bare
  Colour conforming;  ///< elements that need no attention
  Colour attention;   ///< those that do
};
const Theme& light_theme();
const Theme& dark_theme();

}  // namespace weft::picture

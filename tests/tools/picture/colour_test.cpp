// Colour maps and scales.
#include "tools/picture/colour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::picture::colour_test {
namespace {

/// CIE L*, 0 to 100: how light a colour looks.
double lightness(const Colour& colour) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const double y = 0.2126 * linear(colour.red) + 0.7152 * linear(colour.green) + 0.0722 * linear(colour.blue);
  return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

ColourScale scale_of(std::span<const Colour> colours, double lo, double hi,
                     ColourScale::Kind kind = ColourScale::Kind::linear) {
  return {kind, lo, hi, {colours.begin(), colours.end()}, {0.5f, 0.5f, 0.5f}};
}

TEST(Colour, ViridisGetsLighterEvenly) {
  const ColourScale scale = scale_of(viridis(), 0, 1);
  const double first = lightness(scale.colour(0)), last = lightness(scale.colour(1));
  EXPECT_NEAR(first, 15, 2);
  EXPECT_NEAR(last, 91, 2);
  for (int i = 0; i <= 100; ++i)
    EXPECT_NEAR(lightness(scale.colour(i / 100.0)), first + (last - first) * i / 100, 3) << i;
}

TEST(Colour, BlueToRedDarkensAlikeToBothSides) {
  const auto colours = blue_to_red();
  const std::size_t middle = colours.size() / 2;
  for (std::size_t i = 1; i <= middle; ++i) {
    EXPECT_LT(lightness(colours[middle + i]), lightness(colours[middle + i - 1]));
    EXPECT_LT(lightness(colours[middle - i]), lightness(colours[middle - i + 1]));
    EXPECT_NEAR(lightness(colours[middle + i]), lightness(colours[middle - i]), 8);
  }
  EXPECT_GT(colours.front().blue, colours.front().red);
  EXPECT_GT(colours.back().red, colours.back().blue);
}

TEST(Colour, ManyCategoriesDiffer) {
  const auto distance = [](const Colour& a, const Colour& b) {
    return std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue);
  };
  for (std::size_t i = 0; i < 60; ++i) {
    const Colour c = category_colour(i);
    EXPECT_TRUE(std::min({c.red, c.green, c.blue}) >= 0 && std::max({c.red, c.green, c.blue}) <= 1) << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(distance(c, category_colour(j)), 0.03f) << i << " " << j;
  }
}

TEST(Colour, AScaleMeetsItsColoursAndKeepsToItsEnds) {
  const ColourScale scale = scale_of(viridis(), 2, 11);
  for (std::size_t i = 0; i < viridis().size(); ++i)
    EXPECT_NEAR(scale.colour(2 + static_cast<double>(i)).green, viridis()[i].green, 1e-6);
  EXPECT_EQ(scale.colour(-5), viridis().front());
  EXPECT_EQ(scale.colour(50), scale.colour(11));
  EXPECT_EQ(scale.colour(std::numeric_limits<double>::quiet_NaN()), scale.missing);
}

TEST(Colour, ALogarithmicScaleCountsRatios) {
  const ColourScale scale = scale_of(blue_to_red(), 0.5, 2, ColourScale::Kind::logarithmic);
  EXPECT_NEAR(scale.place(1), 0.5, 1e-12);
  EXPECT_NEAR(scale.place(std::sqrt(2.0)), 0.75, 1e-12);
  EXPECT_EQ(scale.colour(0), blue_to_red().front());
}

TEST(Colour, ADiscreteScaleDoesNotBlend) {
  const ColourScale scale = scale_of(viridis(), 0, 1, ColourScale::Kind::discrete);
  for (std::size_t i = 0; i < viridis().size(); ++i)
    EXPECT_EQ(scale.colour(static_cast<double>(i)), viridis()[i]);
}

TEST(Colour, OneValueOnlyHasAColour) {
  const ColourScale scale = scale_of(viridis(), 3, 3);
  EXPECT_GT(lightness(scale.colour(3)), lightness(viridis().front()));
  EXPECT_LT(lightness(scale.colour(3)), lightness(viridis().back()));
}

}  // namespace
}  // namespace weft::picture::colour_test

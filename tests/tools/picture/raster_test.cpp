// The z-buffer.
#include "tools/picture/raster.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace weft::picture::raster_test {
namespace {

using meshing::Point;

constexpr int kSize = 64;
constexpr std::uint32_t kRed = 0xFF0000, kGreen = 0x00FF00, kBlue = 0x0000FF, kWhite = 0xFFFFFF;

/// Red, green and blue for the values 0, 1 and 2 on white; no lines; one sample a pixel.
RasterOptions plain() {
  RasterOptions options;
  options.width = options.height = kSize;
  options.scale = {ColourScale::Kind::discrete, 0, 1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
  options.background = {1, 1, 1};
  options.line_width = 0;
  options.samples = 1;
  return options;
}

/// Looks down the z axis on the unit square, which fills the picture but for the margin.
Camera from_above() {
  static const std::vector<Point> square = {{0, 0, 0}, {1, 1, 0}};
  return {{{0, 0, 1}, {0, 1, 0}}, square, kSize, kSize};
}

Facet facet(const Point& a, const Point& b, const Point& c, double value) {
  return {{a, b, c}, {value, value, value}};
}

/// Two facets over the unit square at the height z.
std::vector<Facet> square(double z, double value) {
  return {facet({0, 0, z}, {1, 0, z}, {1, 1, z}, value), facet({0, 0, z}, {1, 1, z}, {0, 1, z}, value)};
}

std::vector<Facet> together(std::vector<Facet> a, const std::vector<Facet>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// The pixel where a place of the plane is seen.
std::uint32_t at(const Image& image, double x, double y) {
  const Projected p = from_above().project({x, y, 0});
  return image.pixels[static_cast<std::size_t>(p.y) * kSize + static_cast<std::size_t>(p.x)];
}

/// Which pure colour a pixel is, lit more or less; -1 for white.
int category(std::uint32_t pixel) {
  if (pixel == kWhite) return -1;
  const std::uint32_t masks[] = {kRed, kGreen, kBlue};
  for (int i = 0; i < 3; ++i)
    if ((pixel & ~masks[i]) == 0 && pixel != 0) return i;
  return -2;
}

TEST(Raster, TheNearerFacetHidesInEitherOrder) {
  for (const auto& facets : {together(square(0, 0), square(1, 1)), together(square(1, 1), square(0, 0))}) {
    const Image image = rasterize(facets, from_above(), plain());
    EXPECT_EQ(category(at(image, 0.5, 0.5)), 1);
    EXPECT_EQ(category(image.pixels.front()), -1);
  }
}

TEST(Raster, RandomFacetsAreSeenWhereRaysMeetThemFirst) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-0.3, 1.3);
  const auto point = [&] { return Point{coordinate(random), coordinate(random), coordinate(random)}; };
  const Camera camera = from_above();
  int hits = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Facet> facets;
    for (int i = 0; i < 12; ++i) facets.push_back(facet(point(), point(), point(), i % 3));
    const Image image = rasterize(facets, camera, plain());
    for (int k = 0; k < kSize * kSize; ++k) {
      const double x = k % kSize + 0.5, y = static_cast<double>(k / kSize) + 0.5;
      double nearest = 1e9, close_call = 1;
      int expected = -1;
      for (const Facet& f : facets) {
        std::array<Projected, 3> p;
        for (std::size_t i = 0; i < 3; ++i) p[i] = camera.project(f.corners[i]);
        const auto area = [](double ax, double ay, double bx, double by) { return ax * by - bx * ay; };
        const double whole = area(p[1].x - p[0].x, p[1].y - p[0].y, p[2].x - p[0].x, p[2].y - p[0].y);
        const double w1 = area(x - p[0].x, y - p[0].y, p[2].x - p[0].x, p[2].y - p[0].y) / whole;
        const double w2 = area(p[1].x - p[0].x, p[1].y - p[0].y, x - p[0].x, y - p[0].y) / whole;
        const double least = std::min({1 - w1 - w2, w1, w2});
        close_call = std::min(close_call, std::abs(least));
        const double depth = (1 - w1 - w2) * p[0].depth + w1 * p[1].depth + w2 * p[2].depth;
        if (least < 0) continue;
        close_call = std::min(close_call, std::abs(depth - nearest));
        if (depth < nearest) nearest = depth, expected = static_cast<int>(f.values[0]);
      }
      if (close_call < 1e-9) continue;
      ASSERT_EQ(category(image.pixels[static_cast<std::size_t>(k)]), expected);
      hits += expected >= 0;
    }
  }
  EXPECT_GT(hits, 10000);
}

TEST(Raster, NoGapsBetweenNeighbours) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> jitter(-0.03, 0.03);
  constexpr int kCells = 9;
  std::vector<Point> points;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i)
      points.push_back(
          {(2.0 * i - 4) / kCells + jitter(random), (2.0 * j - 4) / kCells + jitter(random), jitter(random)});
  std::vector<Facet> facets;
  for (std::size_t j = 0; j < kCells; ++j)
    for (std::size_t i = 0; i < kCells; ++i) {
      const std::size_t k = j * (kCells + 1) + i;
      facets.push_back(facet(points[k], points[k + 1], points[k + kCells + 2], 0));
      facets.push_back(facet(points[k], points[k + kCells + 2], points[k + kCells + 1], 1));
    }
  RasterOptions options = plain();
  options.samples = 3;
  for (const std::uint32_t pixel : rasterize(facets, from_above(), options).pixels)
    ASSERT_EQ(pixel & 0xFF, 0u);
}

TEST(Raster, LinesLieAtTheEdgesThatAreDrawn) {
  RasterOptions options = plain();
  options.line_width = 4;
  std::vector<Facet> facets = square(0, 0);
  const Image all = rasterize(facets, from_above(), options);
  facets[0].edges[1] = facets[1].edges[2] = false;  // the diagonal
  const Image outline = rasterize(facets, from_above(), options);
  const auto red = [](std::uint32_t pixel) { return pixel >> 16; };
  EXPECT_LT(red(at(all, 0.5, 0.5)), red(at(all, 0.7, 0.3)) / 2);
  EXPECT_EQ(red(at(outline, 0.5, 0.5)), red(at(all, 0.7, 0.3)));
  EXPECT_LT(red(at(outline, 0.5, 0.005)), red(at(outline, 0.7, 0.3)) / 2);
}

TEST(Raster, WithoutLinesNoneAreLeftAtEdges) {
  const std::vector<Point> rim = {{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}, {1, 0.5, 0},
                                  {1, 1, 0}, {0.5, 1, 0}, {0, 1, 0}, {0, 0.5, 0}};
  std::vector<Facet> fan;
  for (std::size_t i = 0; i < 8; ++i) fan.push_back(facet({0.5, 0.5, 0}, rim[i], rim[(i + 1) % 8], 0));
  for (int size = 33; size < 99; size += 2) {  // odd: samples lie on the edges
    RasterOptions options = plain();
    options.width = options.height = size;
    const Camera camera({{0, 0, 1}, {0, 1, 0}}, rim, size, size);
    const Image image = rasterize(fan, camera, options);
    const std::uint32_t middle = image.pixels[image.pixels.size() / 2 + 3] >> 16;
    for (const std::uint32_t pixel : image.pixels) {
      if (pixel == kWhite) continue;
      ASSERT_NEAR(pixel >> 16, middle, 1) << size;
    }
  }
}

TEST(Raster, LinesFadeWhereTheyWouldCoverEverything) {
  std::vector<Facet> strips;
  constexpr int kStrips = 400;  // many a pixel
  for (int i = 0; i < kStrips; ++i) {
    const double x0 = i / double{kStrips}, x1 = (i + 1) / double{kStrips};
    strips.push_back(facet({x0, 0, 0}, {x1, 0, 0}, {x1, 1, 0}, 0));
    strips.push_back(facet({x0, 0, 0}, {x1, 1, 0}, {x0, 1, 0}, 0));
  }
  RasterOptions options = plain();
  options.line_width = 1;
  const std::uint32_t pixel = at(rasterize(strips, from_above(), options), 0.5, 0.5);
  EXPECT_GT(pixel >> 16, 100u);
}

TEST(Raster, ValuesBlendAsTheySay) {
  RasterOptions options = plain();
  Facet thirds = facet({0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, 0);
  thirds.blend = Blend::nearest_edge;
  thirds.values = {0, 1, 2};
  const Image edges = rasterize(std::span(&thirds, 1), from_above(), options);
  EXPECT_EQ(category(at(edges, 0.7, 0.5)), 0);  // opposite (0, 0)
  EXPECT_EQ(category(at(edges, 0.3, 0.5)), 1);
  EXPECT_EQ(category(at(edges, 0.5, 0.1)), 2);

  options.scale = {ColourScale::Kind::linear, 0, 3, {{0, 0, 0}, {1, 0, 0}}, {}};
  Facet slope = facet({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0);
  slope.blend = Blend::linear;
  slope.values = {0, 3, 0};
  const Image image = rasterize(std::span(&slope, 1), from_above(), options);
  const auto red = [&](double x) { return static_cast<double>(at(image, x, 0.1) >> 16); };
  EXPECT_NEAR(red(0.8) / red(0.4), 2, 0.1);
}

TEST(Raster, OnlyTrimmedFacetsEndAtThePlane) {
  RasterOptions options = plain();
  options.trim = Plane{{1, 0, 0}, 0.5};
  std::vector<Facet> facets = square(0, 0);
  for (Facet& f : facets) f.trimmed = true;
  const Image half = rasterize(facets, from_above(), options);
  EXPECT_EQ(category(at(half, 0.45, 0.5)), 0);
  EXPECT_EQ(at(half, 0.55, 0.5), kWhite);
  facets.push_back(facet({0.6, 0, 1}, {1, 0, 1}, {1, 1, 1}, 0));  // all of it in front
  facets.back().trimmed = true;
  const Image both = rasterize(together(facets, square(-1, 2)), from_above(), options);
  EXPECT_EQ(category(at(both, 0.45, 0.5)), 0);
  for (const double x : {0.55, 0.7, 0.9}) EXPECT_EQ(category(at(both, x, 0.3)), 2) << x;
}

TEST(Raster, NothingIsDrawnOfWhatHasNoAreaOrIsElsewhere) {
  const std::vector<Facet> facets = {facet({0, 0, 0}, {1, 1, 0}, {0.5, 0.5, 1}, 0),  // edge-on
                                     facet({0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0),
                                     facet({5, 5, 0}, {6, 5, 0}, {5, 6, 0}, 0)};
  for (const std::uint32_t pixel : rasterize(facets, from_above(), plain()).pixels) ASSERT_EQ(pixel, kWhite);
}

TEST(Raster, AHugeFacetCoversThePicture) {
  const Facet huge = facet({-1e12, -1e12, 0}, {1e12, -1e12, 0}, {0, 1e12, 0}, 2);
  for (const std::uint32_t pixel : rasterize(std::span(&huge, 1), from_above(), plain()).pixels)
    ASSERT_EQ(category(pixel), 2);
}

TEST(Raster, OnlyLitFacetsDarkenAsTheyTurnAway) {
  // Seen on the left half, steep and to the right, and on the right half, flat.
  std::vector<Facet> facets = {facet({0, 0, 0}, {0.5, 0, -3}, {0.5, 1, -3}, 0),
                               facet({0.5, 0, 0}, {1, 0, 0}, {1, 1, 0}, 0)};
  const auto red = [](const Image& image, double x) { return at(image, x, 0.1) >> 16; };
  const Image lit = rasterize(facets, from_above(), plain());
  EXPECT_LT(red(lit, 0.4) + 20, red(lit, 0.9));
  EXPECT_GT(red(lit, 0.4), 0.65 * 255);
  for (Facet& f : facets) f.lit = false;
  const Image unlit = rasterize(facets, from_above(), plain());
  EXPECT_EQ(red(unlit, 0.4), 255u);
  EXPECT_EQ(red(unlit, 0.9), 255u);
}

TEST(Raster, ThreadsDoNotShow) {
  const auto facets = together(square(0, 0), {facet({0, 0, 1}, {1, 0, -1}, {0.5, 1, 0.2}, 1)});
  const auto with_threads = [&](int threads) {
    return tbb::task_arena(threads).execute([&] { return rasterize(facets, from_above(), plain()).pixels; });
  };
  EXPECT_EQ(with_threads(1), with_threads(4));
}

}  // namespace
}  // namespace weft::picture::raster_test

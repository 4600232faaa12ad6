// Facets are sorted into bands of rows; each band finds what is visible, then colours just that. The lines
// come from distances to the edges inside each facet (after Baerentzen et al., 2006), so they hide and are
// hidden as the facets are.
#include "tools/picture/raster.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "meshing/base/parallel.h"

namespace weft::picture {
namespace {

using meshing::Vec;

constexpr int kBandRows = 16;
constexpr std::uint32_t kNothing = 0xFFFFFFFFu;
constexpr double kMostInk = 0.45;   ///< largest share of a facet that its lines may darken
constexpr double kLineShare = 0.8;  ///< how much of a line covers what is below it

/// x, y -> a x + b y + c
struct Affine {
  double a = 0, b = 0, c = 0;
  double operator()(double x, double y) const { return a * x + b * y + c; }
};

/// A facet on the picture.
struct Flat {
  std::array<Affine, 3> weights;   ///< barycentric coordinates
  std::array<double, 3> heights;   ///< over the edge opposite each corner, in pixels
  std::array<double, 3> fronts{};  ///< distances in front of the trimming plane
  Affine depth;
  double x_min, x_max, y_min, y_max;
  std::uint32_t facet;
  float light, ink;  ///< brightness; opacity of its lines
};

/// 1 for a facet that faces the light; never so dark that its colour could be taken for another of the scale.
float light_on(const Facet& facet, const Camera& camera) {
  const auto& [a, b, c] = facet.corners;
  const Vec normal = cross(b - a, c - a);
  const double length = norm(normal);
  if (!facet.lit || !(length > 0)) return 1;
  const double side = dot(normal, camera.toward_eye()) < 0 ? -1 : 1;
  const Vec light = camera.toward_eye() + 0.45 * camera.up() + -0.35 * camera.right();
  const double cosine = side * dot(normal, light) / (length * norm(light));
  return static_cast<float>(0.7 + 0.3 * std::max(cosine, 0.0));
}

Affine interpolation(const std::array<Affine, 3>& weights, double v0, double v1, double v2) {
  const auto& [p, q, r] = weights;
  return {v0 * p.a + v1 * q.a + v2 * r.a, v0 * p.b + v1 * q.b + v2 * r.b, v0 * p.c + v1 * q.c + v2 * r.c};
}

/// Opacity at which the lines of a facet of these heights take no more ink than they may: a line of width w
/// takes, with its half inside the facet, the share w/h.
float ink_of(const Flat& flat, const Facet& facet, double line_width) {
  double share = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (facet.edges[i]) share += line_width / flat.heights[i];
  return static_cast<float>(kLineShare * std::min(1.0, kMostInk / share));
}

/// False for facets seen edge-on and those outside the picture.
bool flatten(const Facet& facet, const Camera& camera, const RasterOptions& options, Flat& flat) {
  std::array<Projected, 3> p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = camera.project(facet.corners[i]);
  flat.x_min = std::min({p[0].x, p[1].x, p[2].x});
  flat.x_max = std::max({p[0].x, p[1].x, p[2].x});
  flat.y_min = std::min({p[0].y, p[1].y, p[2].y});
  flat.y_max = std::max({p[0].y, p[1].y, p[2].y});
  if (flat.x_max < 0 || flat.y_max < 0 || flat.x_min > options.width || flat.y_min > options.height)
    return false;
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
  if (!(std::abs(area) > std::numeric_limits<double>::min())) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Projected &q = p[(i + 1) % 3], &r = p[(i + 2) % 3];
    const double a = (q.y - r.y) / area, b = (r.x - q.x) / area;
    flat.weights[i] = {a, b, -(a * q.x + b * q.y)};
    flat.heights[i] = 1 / std::hypot(a, b);
    if (options.trim && facet.trimmed) flat.fronts[i] = options.trim->distance(facet.corners[i]);
  }
  flat.depth = interpolation(flat.weights, p[0].depth, p[1].depth, p[2].depth);
  flat.light = light_on(facet, camera);
  flat.ink = ink_of(flat, facet, options.line_width);
  return true;
}

struct Sample {
  double depth = std::numeric_limits<double>::infinity();
  std::uint32_t flat = kNothing;
};

/// Some rows of the picture, from `first_row` on, at sample resolution.
class Band {
 public:
  Band(std::span<const Facet> facets, std::span<const Flat> flats, const RasterOptions& options,
       int first_row)
      : facets_(facets),
        flats_(flats),
        options_(options),
        first_row_(first_row),
        rows_(std::min(kBandRows, options.height - first_row)),
        step_(1.0 / options.samples),
        columns_(options.width * options.samples),
        samples_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_ * options.samples)) {}

  /// Makes facet `k` visible where it is nearest.
  void cover(std::uint32_t k) {
    const Flat& flat = flats_[k];
    const auto [top, bottom] =
        range(flat.y_min - first_row_, flat.y_max - first_row_, rows_ * options_.samples);
    const auto [left, right] = range(flat.x_min, flat.x_max, columns_);
    for (int row = top; row < bottom; ++row)
      for (int column = left; column < right; ++column) {
        const double x = x_of(column), y = y_of(row);
        if (!inside(flat, x, y)) continue;
        Sample& sample = at(row, column);
        const double depth = flat.depth(x, y);
        if (depth < sample.depth) sample = {depth, k};
      }
  }

  /// Writes the band's pixels.
  void paint(Image& image) const {
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < options_.width; ++column)
        image.pixels[static_cast<std::size_t>(first_row_ + row) * static_cast<std::size_t>(image.width) +
                     static_cast<std::size_t>(column)] = pixel(row, column);
  }

 private:
  double x_of(int column) const { return (column + 0.5) * step_; }
  double y_of(int row) const { return first_row_ + (row + 0.5) * step_; }
  const Sample& at(int row, int column) const {
    return samples_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(column)];
  }
  Sample& at(int row, int column) { return const_cast<Sample&>(std::as_const(*this).at(row, column)); }

  /// The samples, of `n` in a line, whose middles lie in [lo, hi] pixels: from the first to before the
  /// second.
  std::pair<int, int> range(double lo, double hi, int n) const {
    const double begin = std::clamp(std::ceil(lo * options_.samples - 0.5), 0.0, static_cast<double>(n));
    const double end = std::clamp(std::floor(hi * options_.samples - 0.5) + 1, 0.0, static_cast<double>(n));
    return {static_cast<int>(begin), static_cast<int>(end)};
  }

  /// Points on edges belong to both sides: no sample falls between two facets.
  static bool inside(const Flat& flat, double x, double y) {
    constexpr double kRounding = -1e-12;
    const double w0 = flat.weights[0](x, y), w1 = flat.weights[1](x, y), w2 = flat.weights[2](x, y);
    if (w0 < kRounding || w1 < kRounding || w2 < kRounding) return false;
    return w0 * flat.fronts[0] + w1 * flat.fronts[1] + w2 * flat.fronts[2] <= 0;
  }

  static double value_at(const Facet& facet, const std::array<double, 3>& weights) {
    const auto& v = facet.values;
    if (facet.blend == Blend::constant) return v[0];
    if (facet.blend == Blend::linear) return weights[0] * v[0] + weights[1] * v[1] + weights[2] * v[2];
    return v[static_cast<std::size_t>(std::ranges::min_element(weights) - weights.begin())];
  }

  Colour colour_at(const Flat& flat, double x, double y) const {
    const Facet& facet = facets_[flat.facet];
    const std::array<double, 3> weights = {flat.weights[0](x, y), flat.weights[1](x, y),
                                           flat.weights[2](x, y)};
    const Colour face = mix({0, 0, 0}, options_.scale.colour(value_at(facet, weights)), flat.light);
    // A sample on an edge may have a weight just below zero: without lines none must be drawn there either.
    if (!(options_.line_width > 0)) return face;
    for (std::size_t i = 0; i < 3; ++i)
      if (facet.edges[i] && weights[i] * flat.heights[i] < options_.line_width / 2)
        return mix(face, options_.line, flat.ink);
    return face;
  }

  std::uint32_t pixel(int row, int column) const {
    const int n = options_.samples;
    double red = 0, green = 0, blue = 0;
    for (int i = row * n; i < (row + 1) * n; ++i)
      for (int j = column * n; j < (column + 1) * n; ++j) {
        const std::uint32_t k = at(i, j).flat;
        const Colour c = k == kNothing ? options_.background : colour_at(flats_[k], x_of(j), y_of(i));
        red += c.red;
        green += c.green;
        blue += c.blue;
      }
    const auto byte = [n](double sum) {
      return static_cast<std::uint32_t>(std::lround(255 * sum / (n * n)));
    };
    return byte(red) << 16 | byte(green) << 8 | byte(blue);
  }

  std::span<const Facet> facets_;
  std::span<const Flat> flats_;
  const RasterOptions& options_;
  int first_row_, rows_;
  double step_;  ///< between samples, in pixels
  int columns_;  ///< samples in a row
  std::vector<Sample> samples_;
};

std::vector<Flat> flatten(std::span<const Facet> facets, const Camera& camera, const RasterOptions& options) {
  std::vector<Flat> flats;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    Flat flat;
    if (!flatten(facets[i], camera, options, flat)) continue;
    flat.facet = static_cast<std::uint32_t>(i);
    flats.push_back(flat);
  }
  return flats;
}

/// For each band the facets that reach into it, in their order.
std::vector<std::vector<std::uint32_t>> sort_into_bands(std::span<const Flat> flats, int bands) {
  std::vector<std::vector<std::uint32_t>> members(static_cast<std::size_t>(bands));
  const double last = bands - 1;
  for (std::size_t k = 0; k < flats.size(); ++k) {
    const auto first =
        static_cast<std::size_t>(std::clamp(std::floor(flats[k].y_min / kBandRows), 0.0, last));
    const auto end = static_cast<std::size_t>(std::clamp(std::floor(flats[k].y_max / kBandRows), 0.0, last));
    for (std::size_t band = first; band <= end; ++band)
      members[band].push_back(static_cast<std::uint32_t>(k));
  }
  return members;
}

}  // namespace

Image rasterize(std::span<const Facet> facets, const Camera& camera, const RasterOptions& options) {
  Image image{options.width, options.height, {}};
  image.pixels.resize(static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height));
  const std::vector<Flat> flats = flatten(facets, camera, options);
  const int bands = (options.height + kBandRows - 1) / kBandRows;
  const auto members = sort_into_bands(flats, bands);
  tbb::parallel_for(0, bands, [&](int i) {
    Band band(facets, flats, options, i * kBandRows);
    for (const std::uint32_t k : members[static_cast<std::size_t>(i)]) band.cover(k);
    band.paint(image);
  });
  return image;
}

}  // namespace weft::picture

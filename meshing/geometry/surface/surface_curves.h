// The feature curves of a surface: chains of feature edges between corners, with the points along them. All
// parts of a surface know all of them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/surface/surface.h"

namespace weft::meshing {

/// Shares of a patch's diameter or of a curve's length: what is off by less lies in the plane or on the line;
/// by less than the second it is rounding.
inline constexpr double kFlatness = 1e-6, kRounding = 1e-12;

/// A feature edge as the triangles at it tell.
struct FoundFeature {
  std::array<std::uint32_t, 2> vertices;  ///< ascending
  std::array<Point, 2> ends;
  std::int32_t ref;
  std::array<std::uint8_t, 2> corners;  ///< whether the ends are corners
  std::uint8_t required;
  std::uint8_t unused = 0;  ///< no byte of a message is undefined
};

struct Line {
  Point point;
  Vec direction;        ///< unit; components below 1e-12 are zero
  double rounding = 0;  ///< 1e-12 of the curve's length
};

/// Features are numbered in the order of their vertices.
struct SurfaceCurves {
  std::vector<std::array<std::uint32_t, 2>> features;  ///< vertices, ascending
  std::vector<CurveId> curve_of;                       ///< feature -> curve
  std::vector<std::uint32_t> place_of;                 ///< feature -> its place in chain_features
  std::vector<Curve> curves;
  std::vector<Line> lines;            ///< curve -> line; of straight ones
  std::vector<std::uint8_t> endless;  ///< curves whose first vertex is their last and no corner
  /// Curve -> range of chain_features; its vertices start at begin + curve, one more than edges.
  std::vector<std::uint32_t> chain_begin;
  std::vector<std::uint32_t> chain_features;
  std::vector<std::uint32_t> chain_vertices;
  std::vector<Point> chain_points;  ///< of chain_vertices
  std::vector<Vec> tangents;        ///< of chain_vertices, unit, along the chain

  std::span<const std::uint32_t> chain(CurveId c) const {
    return std::span(chain_features).subspan(chain_begin[c.value], num_edges(c));
  }
  std::span<const Point> points_along(CurveId c) const {
    return std::span(chain_points).subspan(chain_begin[c.value] + c.value, num_edges(c) + 1);
  }
  std::uint32_t num_edges(CurveId c) const { return chain_begin[c.value + 1] - chain_begin[c.value]; }
  /// Whether its curve runs from the feature's lower vertex to the upper one.
  bool forward(std::uint32_t feature) const {
    return chain_vertices[place_of[feature] + curve_of[feature].value] == features[feature][0];
  }
  /// The curve's tangent at a vertex of one of its features; none where the curve is a single edge of an
  /// unknown shape.
  const Vec* tangent_at(std::uint32_t feature, std::uint32_t vertex) const {
    const CurveId c = curve_of[feature];
    if (num_edges(c) == 1) return nullptr;
    const std::uint32_t first = place_of[feature] + c.value;
    return &tangents[chain_vertices[first] == vertex ? first : first + 1];
  }
};

/// Of all features, in the order of their vertices. Curves are numbered by the corners where they begin and
/// their first edges there, then those without ends. Finds which are straight, and the tangents.
SurfaceCurves form_curves(std::span<const FoundFeature> features);

/// The unit vector with components lost in rounding exactly zero, so that axis-aligned planes and lines are
/// exact.
Vec on_axes(const Vec& unit);

}  // namespace weft::meshing

// The feature curves of a surface: chains of feature edges between corners, and the tangents along them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <tuple>
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

/// Where a feature edge lies on its curve.
struct FeatureOnCurve {
  CurveId curve;
  std::uint8_t forward = 0;  ///< the curve runs from the edge's lower vertex to its upper one
  std::uint8_t first = 0;    ///< it begins with this edge
  std::uint8_t alone = 0;    ///< it is this edge, and of unknown shape
  std::uint8_t unused = 0;
  std::array<Vec, 2> tangents{};  ///< the curve's, unit, at the lower and at the upper vertex

  /// None where the curve is a single edge of an unknown shape. `end`: 0 or 1.
  const Vec* tangent(std::size_t end) const { return alone ? nullptr : &tangents[end]; }
};

/// A curve as its edges tell.
struct FoundCurve {
  // Curves are numbered in the order of these: those without a corner last.
  std::uint32_t endless;               ///< 0 or 1: its first vertex is its last and no corner
  std::uint32_t begin;                 ///< the vertex where it begins
  std::array<std::uint32_t, 2> first;  ///< its first edge's vertices

  std::int32_t ref;
  std::uint16_t required, straight;  ///< 0 or 1
  Line line;                         ///< where it is straight
  Vec chord;                         ///< from its first vertex to its last
  double length;                     ///< of all edges

  auto order() const { return std::tuple{endless, begin, first}; }
  Curve curve() const { return {ref, straight != 0, required != 0}; }
};

struct FormedCurves {
  std::vector<FoundCurve> curves;           ///< in their order
  std::vector<FeatureOnCurve> of_features;  ///< by features as given
};

/// Of features that make up whole curves, in the order of their vertices. A curve begins at the corner of the
/// lowest number, there with the lowest edge. Finds which are straight, and the tangents.
FormedCurves form_curves(std::span<const FoundFeature> features);

/// The unit vector with components lost in rounding exactly zero, so that axis-aligned planes and lines are
/// exact.
Vec on_axes(const Vec& unit);

}  // namespace weft::meshing

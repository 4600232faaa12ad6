// Points that lie on an input edge or triangle exactly, though doubles cannot say where: boundary recovery
// takes no decision by rounded coordinates.
#pragma once

#include <array>

#include "meshing/base/point.h"

namespace weft::meshing {

/// The unevaluated sum of doubles, each a correction of those before it.
struct Parameter {
  std::array<double, 4> terms{};
};

/// origin + s (u - origin) + t (v - origin), without rounding. A plain point has s = t = 0.
struct ExactPlace {
  Point origin, u, v;
  Parameter s, t;

  static ExactPlace at(const Point& p) { return {p, p, p, {}, {}}; }
  Point rounded() const;
};

/// Sign (-1, 0, 1) of det(b-a, c-a, d-a): by intervals where they decide, else by exact arithmetic.
int orientation(const ExactPlace& a, const ExactPlace& b, const ExactPlace& c, const ExactPlace& d);

/// Where the line from a to b meets the plane through the triangle: a + s (b - a), s correct to all its
/// doubles. The line may not be parallel to the plane.
ExactPlace place_on_edge(const Point& a, const Point& b, const std::array<ExactPlace, 3>& triangle);

/// Where the line through p and q meets the triangle's plane, as a place in that plane, both parameters
/// correct to all their doubles. The line may not be parallel to the plane.
ExactPlace place_on_facet(const std::array<Point, 3>& triangle, const ExactPlace& p, const ExactPlace& q);

}  // namespace weft::meshing

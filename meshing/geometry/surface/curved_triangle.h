// Cubic arcs and cubic triangles (PN triangles) and the closest points on them.
#pragma once

#include <array>

#include "meshing/base/point.h"

namespace weft::meshing {

/// A cubic Bezier arc in Hermite form: it leaves `a` along handle_a and arrives at b from b + handle_b, the
/// handles being its two inner control points relative to the ends.
struct CubicArc {
  Point a, b;
  Vec handle_a, handle_b;
};

struct ArcPoint {
  double s = 0;  ///< 0 at a, 1 at b; exactly so where the closest point is an end
  double distance2 = 0;
  Point x;
  Vec tangent;  ///< unit, from a to b
};

/// Closest point of the arc near parameter `start`, by Newton's method.
ArcPoint closest_point(const CubicArc& arc, const Point& p, double start);

using Barycentric = std::array<double, 3>;

struct TrianglePoint {
  Barycentric at{};  ///< weights exactly zero where the closest point is on an edge or a vertex
  double distance2 = 0;
};

/// Closest point of the flat triangle (Ericson, Real-Time Collision Detection, 5.1.5); any shape, even none.
TrianglePoint closest_point(const Point& a, const Point& b, const Point& c, const Point& p);

/// A PN triangle (Vlachos et al. 2001): the cubic Bezier triangle whose inner control point follows from the
/// six on its edges. Evaluated relative to its first vertex, so that what is exactly flat in a coordinate
/// stays so.
class CurvedTriangle {
 public:
  /// handles[i] are the inner control points of edge i (from corner i+1 to i+2), relative to its two ends.
  CurvedTriangle(const std::array<Point, 3>& corners, const std::array<std::array<Vec, 2>, 3>& handles);

  struct Jet {
    Vec x;       ///< relative to the first corner
    Vec d1, d2;  ///< derivatives by the weights of corners 1 and 2, that of corner 0 taking up the change
    Vec d11, d12, d22;
  };
  Jet evaluate(const Barycentric& at) const;

  struct Frame {
    Point x;
    Vec normal;  ///< unit; zero where the triangle is degenerate
  };
  Frame frame(const Barycentric& at) const;
  /// Closest point near `start`, by Newton's method kept inside the triangle.
  TrianglePoint closest(const Point& p, const Barycentric& start) const;

 private:
  Point origin_;
  // Control points relative to origin_, by the power of the weights: c_[ijk] of b0^i b1^j b2^k. c300 is zero.
  Vec c030_, c003_, c210_, c120_, c021_, c012_, c102_, c201_, c111_;
};

}  // namespace weft::meshing

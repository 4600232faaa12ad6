// Exact orientation: a fast static filter in front, CGAL's exact predicate behind it.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "meshing/base/point.h"

namespace weft::meshing {

/// CGAL's exact sign (-1, 0, 1) of det(b-a, c-a, d-a); 0 where a coordinate is not finite.
int orientation_exact(const Point& a, const Point& b, const Point& c, const Point& d);
/// CGAL's exact side of `e` to the circumsphere of the positive tet (a, b, c, d): 1 inside, -1 outside.
int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e);
/// Whether three points lie on one line exactly.
bool collinear(const Point& a, const Point& b, const Point& c);
/// For coplanar points: whether c and d lie strictly on the same side of the line through a and b.
bool on_same_side(const Point& a, const Point& b, const Point& c, const Point& d);
/// Whether closed triangles, or a closed segment and a closed triangle, have a point in common. None may be
/// degenerate.
bool triangles_meet(const std::array<Point, 3>& s, const std::array<Point, 3>& t);
bool segment_meets_triangle(const Point& a, const Point& b, const std::array<Point, 3>& t);

/// Sign of det(b-a, c-a, d-a): from doubles where a forward error bound (Shewchuk 1997, stage A:
/// 7.8e-16 times the permanent) proves it, from CGAL otherwise; 0 where a coordinate is not finite.
inline int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Vec u = b - a, v = c - a, w = d - a;
  const double yz = v.y * w.z, zy = v.z * w.y, zx = v.z * w.x, xz = v.x * w.z, xy = v.x * w.y, yx = v.y * w.x;
  const double det = u.x * (yz - zy) + u.y * (zx - xz) + u.z * (xy - yx);
  const double permanent = std::abs(u.x) * (std::abs(yz) + std::abs(zy)) +
                           std::abs(u.y) * (std::abs(zx) + std::abs(xz)) +
                           std::abs(u.z) * (std::abs(xy) + std::abs(yx));
  // The least normal number where products are smaller than that.
  const double bound = 1e-15 * permanent + std::numeric_limits<double>::min();
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return orientation_exact(a, b, c, d);
}

}  // namespace weft::meshing

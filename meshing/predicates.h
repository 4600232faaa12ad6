// Exact orientation: a fast static filter in front, CGAL's exact predicate behind it.
#pragma once

#include <cmath>

#include "meshing/point.h"

namespace weft::meshing {

/// CGAL's exact sign (-1, 0, 1) of det(b-a, c-a, d-a).
int orientation_exact(const Point& a, const Point& b, const Point& c, const Point& d);

/// Sign of det(b-a, c-a, d-a): from doubles where a forward error bound (Shewchuk 1997, stage A:
/// 7.8e-16 times the permanent) proves it, from CGAL otherwise.
inline int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Vec u = b - a, v = c - a, w = d - a;
  const double yz = v.y * w.z, zy = v.z * w.y, zx = v.z * w.x, xz = v.x * w.z, xy = v.x * w.y, yx = v.y * w.x;
  const double det = u.x * (yz - zy) + u.y * (zx - xz) + u.z * (xy - yx);
  const double permanent = std::abs(u.x) * (std::abs(yz) + std::abs(zy)) +
                           std::abs(u.y) * (std::abs(zx) + std::abs(xz)) +
                           std::abs(u.z) * (std::abs(xy) + std::abs(yx));
  const double bound = 1e-15 * permanent;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return orientation_exact(a, b, c, d);
}

}  // namespace weft::meshing

// Points and vectors of three doubles, with the few operations that geometry needs.
#pragma once

#include <cmath>

#include "weft/data.h"

namespace weft::meshing {

using Vec = Point;

inline Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator*(double s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Point& operator+=(Point& a, const Point& b) {
  a.x += b.x;
  a.y += b.y;
  a.z += b.z;
  return a;
}
inline double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm2(const Vec& a) { return dot(a, a); }
inline double norm(const Vec& a) { return std::sqrt(norm2(a)); }
/// Of length 1; the zero vector stays.
inline Vec normalized(const Vec& v) {
  const double length = norm(v);
  return length > 0 ? (1 / length) * v : Vec{};
}
inline Point midpoint(const Point& a, const Point& b) {
  return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (a.z + b.z)};
}

inline bool is_finite(const Point& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Six times the signed volume of tet (a,b,c,d): positive when d sees a,b,c counter-clockwise from
/// the outside of face abc, i.e. det(b-a, c-a, d-a) > 0, CGAL's POSITIVE.
inline double six_volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  return dot(cross(b - a, c - a), d - a);
}

}  // namespace weft::meshing

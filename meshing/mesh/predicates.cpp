// CGAL's kernel of exact predicates.
#include "meshing/mesh/predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace weft::meshing {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;

K::Point_3 cgal(const Point& p) { return {p.x, p.y, p.z}; }
K::Triangle_3 cgal(const std::array<Point, 3>& t) { return {cgal(t[0]), cgal(t[1]), cgal(t[2])}; }

}  // namespace

int orientation_exact(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (!(is_finite(a) && is_finite(b) && is_finite(c) && is_finite(d))) return 0;  // CGAL's numbers are
  return static_cast<int>(CGAL::orientation(cgal(a), cgal(b), cgal(c), cgal(d)));
}

int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  return static_cast<int>(CGAL::side_of_oriented_sphere(cgal(a), cgal(b), cgal(c), cgal(d), cgal(e)));
}

bool collinear(const Point& a, const Point& b, const Point& c) {
  return CGAL::collinear(cgal(a), cgal(b), cgal(c));
}

bool on_same_side(const Point& a, const Point& b, const Point& c, const Point& d) {
  return CGAL::coplanar_orientation(cgal(a), cgal(b), cgal(c), cgal(d)) == CGAL::POSITIVE;
}

bool triangles_meet(const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
  return CGAL::do_intersect(cgal(s), cgal(t));
}

bool segment_meets_triangle(const Point& a, const Point& b, const std::array<Point, 3>& t) {
  return CGAL::do_intersect(K::Segment_3(cgal(a), cgal(b)), cgal(t));
}

}  // namespace weft::meshing

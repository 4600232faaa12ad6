// The only place that names CGAL's kernel.
#include "meshing/predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace weft::meshing {

int orientation_exact(const Point& a, const Point& b, const Point& c, const Point& d) {
  using P = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  return static_cast<int>(
      CGAL::orientation(P(a.x, a.y, a.z), P(b.x, b.y, b.z), P(c.x, c.y, c.z), P(d.x, d.y, d.z)));
}

}  // namespace weft::meshing

// The normals of faces and the products of edges (Gottschalk, Lin and Manocha, 1996).
#include "partition/fields/tets_meet.h"

#include <algorithm>
#include <limits>

#include "meshing/mesh/tet_tables.h"

namespace weft::partition {
namespace {

using meshing::Vec;

struct Extent {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
};

Extent along(const TetCorners& tet, const Vec& axis, const meshing::Point& origin) {
  Extent extent;
  for (const meshing::Point& p : tet) {
    const double x = dot(axis, p - origin);
    extent.lo = std::min(extent.lo, x);
    extent.hi = std::max(extent.hi, x);
  }
  return extent;
}

/// Rounding moves extents by far less than the margin, but where the axis is nearly none.
bool separates(const Vec& axis, const TetCorners& a, const TetCorners& b) {
  constexpr double kMargin = 1e-4;
  const Extent x = along(a, axis, a[0]), y = along(b, axis, a[0]);
  const double margin = kMargin * (x.hi - x.lo);
  return margin > 0 && (y.lo > x.hi + margin || y.hi < x.lo - margin);
}

}  // namespace

bool tets_meet(const TetCorners& a, const TetCorners& b) {
  const auto edge = [](const TetCorners& tet, std::size_t e) {
    return tet[static_cast<std::size_t>(meshing::kTetEdges[e][1])] -
           tet[static_cast<std::size_t>(meshing::kTetEdges[e][0])];
  };
  for (const TetCorners* tet : {&a, &b})
    for (const auto& f : meshing::kTetFaces) {
      const auto &p = (*tet)[static_cast<std::size_t>(f[0])], &q = (*tet)[static_cast<std::size_t>(f[1])],
                 &r = (*tet)[static_cast<std::size_t>(f[2])];
      if (separates(cross(q - p, r - p), a, b)) return false;
    }
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      if (separates(cross(edge(a, i), edge(b, j)), a, b)) return false;
  return true;
}

}  // namespace weft::partition

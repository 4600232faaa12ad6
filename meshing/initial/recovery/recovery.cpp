#include "meshing/initial/recovery/recovery.h"

#include <fmt/format.h>

#include <algorithm>

#include "meshing/base/error.h"

namespace weft::meshing {

void throw_too_thin(std::uint32_t facet) {
  throw InputError("", fmt::format("triangle {}", facet + 1),
                   "cannot be made part of a mesh: the surface is too thin there for double precision");
}

Point Recovery::above(std::uint32_t facet) const {
  const auto& [a, b, c] = facets[facet];
  const Point &p = grid.points[a], &q = grid.points[b], &r = grid.points[c];
  const Vec normal = cross(q - p, r - p);
  const double size = std::max(norm(q - p), norm(r - p)), length = norm(normal);
  std::vector<Vec> ways = {{size, 0, 0}, {0, size, 0}, {0, 0, size}};
  if (length > 0) ways.insert(ways.begin(), (size / length) * normal);
  for (const double sign : {1.0, -1.0})
    for (const Vec& way : ways)
      if (grid.orient(a, b, c, p + sign * way) > 0) return p + sign * way;
  return p;
}

int Recovery::sliver_cost(std::span<const std::uint32_t> tets) const {
  int cost = 0;
  for (const std::uint32_t t : tets) cost += sliver_cost(grid.tets[t].v);
  return cost;
}

}  // namespace weft::meshing

#include "meshing/initial/recovery/recovery.h"

#include <fmt/format.h>

#include <algorithm>

#include "meshing/base/error.h"

namespace weft::meshing {

namespace {

std::string name_of(std::uint32_t facet, std::span<const std::uint32_t> source) {
  return fmt::format("triangle {}", (facet < source.size() ? source[facet] : facet) + 1);
}

}  // namespace

void Recovery::refuse_facet(std::uint32_t facet) const {
  throw InputError("", name_of(facet, source), kTooThin);
}

void Recovery::refuse_edge(std::uint32_t edge, const std::string& reason) const {
  const auto facet = std::ranges::find_if(
      facet_edges, [&](const auto& of_facet) { return std::ranges::find(of_facet, edge) != of_facet.end(); });
  const Point p = midpoint(grid.points[edges[edge].a], grid.points[edges[edge].b]);
  throw InputError("", name_of(static_cast<std::uint32_t>(facet - facet_edges.begin()), source),
                   fmt::format("its edge near ({:.6g}, {:.6g}, {:.6g}) {}", p.x, p.y, p.z, reason));
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

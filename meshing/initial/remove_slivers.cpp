// Flat tets give way to edge swaps that make fewer of them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "meshing/initial/recovery.h"

namespace weft::meshing {
namespace {

/// Whether the tet is flatter than 1e-9 of its shortest edge.
bool is_sliver(const TetGrid& grid, const Tet4& v) {
  const auto& p = grid.points;
  double shortest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const auto& e : kTetEdges) shortest = std::min(shortest, norm2(p[v[e[0]]] - p[v[e[1]]]));
  for (const auto& f : kTetFaces) {
    const Point& a = p[v[f[0]]];
    largest = std::max(largest, norm2(cross(p[v[f[1]]] - a, p[v[f[2]]] - a)));
  }
  return six_volume(p[v[0]], p[v[1]], p[v[2]], p[v[3]]) < 1e-9 * std::sqrt(largest * shortest);
}

int slivers_around(TetGrid& grid, std::uint32_t tet, std::uint32_t a, std::uint32_t b) {
  TetGrid::EdgeShell shell;
  grid.shell(tet, a, b, shell);
  int count = 0;
  for (const std::uint32_t t : shell.tets) count += is_sliver(grid, grid.tets[t].v);
  return count;
}

bool swap_away(Recovery& r, std::uint32_t t) {
  const Tet4 v = r.grid.tets[t].v;
  for (const auto& e : kTetEdges) {
    const std::uint32_t a = v[e[0]], b = v[e[1]];
    const auto cost = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
      return int{is_sliver(r.grid, {x, y, z, b})} + int{is_sliver(r.grid, {y, x, z, a})};
    };
    const auto no_cost = [](std::uint32_t, std::uint32_t) { return 0; };
    if (remove_edge(r, a, b, slivers_around(r.grid, t, a, b), cost, no_cost)) return true;
  }
  return false;
}

}  // namespace

void remove_slivers(Recovery& r) {
  for (std::uint32_t t = 0; t < r.grid.tets.size(); ++t)
    while (r.grid.alive(t) && is_sliver(r.grid, r.grid.tets[t].v) && swap_away(r, t)) {
    }
}

}  // namespace weft::meshing

// Flat tets give way to edge swaps that make fewer of them.
#include "meshing/initial/recovery/remove_slivers.h"

#include <algorithm>

#include "meshing/initial/recovery/remove_edge.h"

namespace weft::meshing {
namespace {

int slivers_around(TetGrid& grid, std::uint32_t tet, std::uint32_t a, std::uint32_t b) {
  TetGrid::EdgeShell shell;
  grid.shell(tet, a, b, shell);
  int count = 0;
  for (const std::uint32_t t : shell.tets) count += grid.sliver(grid.tets[t].v);
  return count;
}

bool swap_away(Recovery& r, std::uint32_t t) {
  const Tet4 v = r.grid.tets[t].v;
  for (const auto& e : kTetEdges) {
    const std::uint32_t a = v[e[0]], b = v[e[1]];
    const auto cost = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
      return int{r.grid.sliver({x, y, z, b})} + int{r.grid.sliver({y, x, z, a})};
    };
    const auto no_cost = [](std::uint32_t, std::uint32_t) { return 0; };
    if (remove_edge(r, a, b, slivers_around(r.grid, t, a, b), cost, no_cost)) return true;
  }
  return false;
}

}  // namespace

void remove_slivers(Recovery& r) {
  for (std::uint32_t t = 0; t < r.grid.tets.size(); ++t)
    while (r.grid.alive(t) && r.grid.sliver(r.grid.tets[t].v) && swap_away(r, t)) {
    }
}

}  // namespace weft::meshing

// Exchange of the tets around an edge: dynamic programming over the chains of its ring (Klincsek 1980).
#pragma once

#include <climits>
#include <cstdint>
#include <vector>

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing::detail {

inline constexpr std::size_t kMostRing = 12;

/// Least costs of triangulating the ring's chains i..j, and where each is cut.
struct RingCosts {
  int cost[kMostRing][kMostRing];
  std::size_t cut[kMostRing][kMostRing];
};

/// The tets over the ring's triangles below chain i..j.
inline void ring_tets(const RingCosts& c, const std::vector<std::uint32_t>& ring, std::uint32_t a,
                      std::uint32_t b, std::size_t i, std::size_t j, std::vector<Tet4>& out) {
  if (j < i + 2) return;
  const std::size_t k = c.cut[i][j];
  out.push_back({ring[i], ring[k], ring[j], b});
  out.push_back({ring[k], ring[i], ring[j], a});
  ring_tets(c, ring, a, b, i, k, out);
  ring_tets(c, ring, a, b, k, j, out);
}

/// Whether the shell may be exchanged at all: closed, small, no facet between its tets.
inline bool exchangeable(const TetGrid& grid, const TetGrid::EdgeShell& shell, std::uint32_t a,
                         std::uint32_t b) {
  if (!shell.closed || shell.ring.size() < 3 || shell.ring.size() > kMostRing) return false;
  for (const std::uint32_t t : shell.tets)
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t v = grid.tets[t].v[f];
      if (v != a && v != b && grid.tets[t].facet[f] != kNothing) return false;
    }
  return true;
}

}  // namespace weft::meshing::detail

namespace weft::meshing {

/// Exchanges the tets around edge (a, b) for tets on the triangulation of its ring of least cost, where that
/// is below `limit`: `triangle_cost(r, s, t)` for each ring triangle and `diagonal_cost(r, s)` for each
/// diagonal. Facet faces and input edges stay.
template <class TriangleCost, class DiagonalCost>
bool remove_edge(Recovery& r, std::uint32_t a, std::uint32_t b, int limit, const TriangleCost& triangle_cost,
                 const DiagonalCost& diagonal_cost) {
  TetGrid& grid = r.grid;
  if (r.edge_at.contains(Recovery::key(a, b))) return false;
  TetGrid::EdgeShell shell;
  grid.shell(grid.tet_with_edge(a, b), a, b, shell);
  if (!detail::exchangeable(grid, shell, a, b)) return false;
  const auto& ring = shell.ring;
  const std::size_t n = ring.size();
  detail::RingCosts c;
  for (std::size_t i = 0; i + 1 < n; ++i) c.cost[i][i + 1] = 0;
  for (std::size_t width = 2; width < n; ++width)
    for (std::size_t i = 0; i + width < n; ++i) {
      const std::size_t j = i + width;
      c.cost[i][j] = limit;
      const int diagonal = width + 1 < n ? diagonal_cost(ring[i], ring[j]) : 0;
      for (std::size_t k = i + 1; k < j; ++k) {
        if (c.cost[i][k] + c.cost[k][j] + diagonal >= c.cost[i][j]) continue;
        const int cost = c.cost[i][k] + c.cost[k][j] + diagonal + triangle_cost(ring[i], ring[k], ring[j]);
        if (cost >= c.cost[i][j] || !grid.positive({ring[i], ring[k], ring[j], b}) ||
            !grid.positive({ring[k], ring[i], ring[j], a}))
          continue;
        c.cost[i][j] = cost;
        c.cut[i][j] = k;
      }
    }
  if (c.cost[0][n - 1] >= limit) return false;
  std::vector<Tet4> fresh;
  detail::ring_tets(c, ring, a, b, 0, n - 1, fresh);
  grid.replace(shell.tets, fresh);
  ++r.flips;
  return true;
}

}  // namespace weft::meshing

// What boundary recovery works on: the grid, and what of the input surface is in it already.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing {

/// An edge of the input surface, in the grid as a chain of edges through Steiner points.
struct InputEdge {
  std::uint32_t a, b;
  std::vector<std::uint32_t> chain;  ///< Steiner points from a to b
};

/// A point that recovery put on an input edge, or (edge == kNothing) on a facet.
struct SteinerPoint {
  std::uint32_t vertex, edge, facet;
};

struct Recovery {
  TetGrid grid;
  std::vector<Face3> facets;                              ///< the input triangles
  std::vector<std::array<std::uint32_t, 3>> facet_edges;  ///< edge i runs from corner i to corner i + 1
  std::vector<InputEdge> edges;
  std::unordered_map<std::uint64_t, std::uint32_t> edge_at;  ///< grid edge -> input edge it is part of
  std::vector<SteinerPoint> steiner;
  std::uint64_t flips = 0;

  /// A point off the facet's plane, on the side from which it turns counter-clockwise.
  Point above(std::uint32_t facet) const;

  /// What a tet, or the slivers among some, count for in exchanges: more than any obstacle to recovery,
  /// because slivers multiply.
  int sliver_cost(const Tet4& v) const { return grid.sliver(v) ? kSliverCost : 0; }
  int sliver_cost(std::span<const std::uint32_t> tets) const;
  static constexpr int kSliverCost = 10000;

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }
};

/// Throws InputError: the facet cannot be made part of a mesh.
[[noreturn]] void throw_too_thin(std::uint32_t facet);

/// Swaps away tets that are flat to rounding (of cospherical points in one plane): they leave Steiner points
/// no room.
void remove_slivers(Recovery& r);

/// Lists the edges of the facets.
void list_input_edges(Recovery& r);

/// Connects point v to a cavity around it that starts as `seed` (the tets of the face or edge that it is on)
/// and grows beyond faces that v does not see or, if that can be, sees too flatly. False, and nothing done,
/// where a facet, an input edge or a vertex would be lost.
bool insert_steiner(Recovery& r, std::span<const std::uint32_t> seed, std::uint32_t v);

/// Moves the Steiner point v along its input edge, between two parameters, to where the worst tet of its ball
/// is best.
void relax_on_edge(Recovery& r, std::uint32_t v, double least, double most);

/// The same within a facet that is not yet marked.
void relax_on_facet(Recovery& r, std::uint32_t v);

/// Makes every input edge a chain of grid edges: flips where they do, Steiner points on the edge elsewhere.
/// Throws InputError naming the ends (1-based) where not even that is possible.
void recover_edges(Recovery& r);

/// Makes every facet a set of grid faces and marks them: flips where they do, Steiner points where the facet
/// cuts grid edges elsewhere. The input edges must be there. Throws InputError naming the triangle.
void recover_facets(Recovery& r);

/// Moves Steiner points off the surface into the tets beside it, one copy for each side, and closes the
/// facets without them: the surface is then the input's, triangle by triangle. Those that find no
/// room there stay; returns their number. Only tets that are in use may be in the grid.
std::uint64_t lift_steiner_points(Recovery& r);

/// Puts those that are left at doubles. Throws InputError naming the triangle where that would turn a tet
/// over.
void round_steiner_points(Recovery& r);

/// Gives the worst tets better neighbourhoods, with added points or without those that are.
void improve_tets(Recovery& r);

/// Exchanges the tets around edge (a, b) for tets on the triangulation of its ring of least cost, where that
/// is below `limit`: `triangle_cost(r, s, t)` for each ring triangle and `diagonal_cost(r, s)` for each
/// diagonal. Facet faces and input edges stay.
template <class TriangleCost, class DiagonalCost>
bool remove_edge(Recovery& r, std::uint32_t a, std::uint32_t b, int limit, const TriangleCost& triangle_cost,
                 const DiagonalCost& diagonal_cost);

}  // namespace weft::meshing

#include "meshing/initial/recovery/remove_edge_inl.h"

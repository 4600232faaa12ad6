// What boundary recovery works on: the grid, and what of the input surface is in it already.
#pragma once

#include <cstdint>
#include <span>
#include <string>
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
  std::span<const std::uint32_t> source = {};  ///< of each facet: its number in messages; empty: its own

  /// A point off the facet's plane, on the side from which it turns counter-clockwise.
  Point above(std::uint32_t facet) const;

  /// What a tet, or the slivers among some, count for in exchanges: more than any obstacle to recovery,
  /// because slivers multiply.
  int sliver_cost(const Tet4& v) const { return grid.sliver(v) ? kSliverCost : 0; }
  int sliver_cost(std::span<const std::uint32_t> tets) const;
  static constexpr int kSliverCost = 10000;

  /// Throw InputError, naming a triangle of the input: what cannot be made part of a mesh.
  [[noreturn]] void refuse_facet(std::uint32_t facet) const;
  [[noreturn]] void refuse_edge(std::uint32_t edge, const std::string& reason) const;
  static constexpr const char* kTooThin =
      "cannot be made part of a mesh: the surface is too thin there for double precision";

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }
};

}  // namespace weft::meshing

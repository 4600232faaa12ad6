// Connectivity derived from plain tet arrays: face neighbours, the tet faces of triangles, unique edges,
// neighbours and tets of vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// What stands for "nothing on the other side".
inline constexpr std::uint32_t kNoNeighbour = 0xFFFFFFFFu;

/// For every tet and face i (the one opposite vertex i) the code of the same face seen from the tet on its
/// other side: neighbour_tet * 4 + neighbour_face, or kNoNeighbour on the boundary.
struct Adjacency {
  std::vector<std::array<std::uint32_t, 4>> neighbours;
  /// Whether every two neighbours see their face turn in opposite ways, as positive tets that do not overlap
  /// do.
  bool turns_differ = true;
};

/// All functions here: multithreaded on TBB (in the caller's arena), linear time, the same result for any
/// number of threads. They throw InputError for a vertex >= num_vertices and for more tets than codes can
/// name.

/// Throws InputError naming the tets (1-based) when a face belongs to more than two. Temporaries: about 25
/// bytes a tet where tets that share faces are near each other, 150 at worst.
Adjacency build_adjacency(std::span<const Tet> tets, std::size_t num_vertices);

/// For every triangle the code tet * 4 + face of the tet face with the same three vertices (of two such, the
/// smaller code), kNoNeighbour where there is none.
std::vector<std::uint32_t> match_triangles(std::span<const Triangle> triangles, std::span<const Tet> tets,
                                           std::size_t num_vertices);

/// Every edge of the tets once, stored at its smaller end: the larger ends of v's edges, ascending, are
/// others[begins[v]] to others[begins[v + 1] - 1].
struct EdgeLists {
  std::vector<std::size_t> begins;  ///< one more than there are vertices
  std::vector<std::uint32_t> others;
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return {others.data() + begins[vertex], others.data() + begins[vertex + 1]};
  }
};
/// Temporaries: about 20 bytes a tet where tets that share edges are near each other, 90 at worst.
EdgeLists unique_edges(std::span<const Tet> tets, std::size_t num_vertices);

/// Lists of indices, one a vertex, in one array: those of v are items[begins[v]] to items[begins[v + 1] - 1],
/// ascending.
struct VertexLists {
  std::vector<std::size_t> begins;  ///< one more than there are vertices
  std::vector<std::uint32_t> items;
  std::span<const std::uint32_t> of(std::size_t vertex) const {
    return {items.data() + begins[vertex], items.data() + begins[vertex + 1]};
  }
};
/// The vertices joined to each vertex by an edge.
VertexLists vertex_neighbours(std::span<const Tet> tets, std::size_t num_vertices);
/// The tets at each vertex.
VertexLists vertex_tets(std::span<const Tet> tets, std::size_t num_vertices);

}  // namespace weft::meshing

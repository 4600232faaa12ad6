// The dual graph of tets: who shares a face with whom.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace weft::partition {

/// A tet as a vertex of the dual graph.
struct DualVertex {
  std::uint64_t number;  ///< in the whole input
  std::uint64_t weight;
  std::array<std::uint32_t, 4> vertices;
  std::array<float, 4> face_areas;  ///< in the metric; face i is opposite vertex i
};

/// Compressed rows: the neighbours of tet t, and the weights of the faces shared with them, are entries
/// begins[t] to begins[t + 1].
struct DualGraph {
  std::vector<std::int32_t> begins, neighbours;
  std::vector<double> face_weights;
};

/// The graph of these tets, in their order. A face weighs the number of vertices that an interface along it
/// will have: its area in the metric, the mean of what its two tets say, over that of two unit triangles, and
/// half a vertex, since it is there already. Fewer than 2^29 tets, no three at a face.
DualGraph dual_graph(std::span<const DualVertex> tets);

}  // namespace weft::partition

// By sorting all sides of the outer triangles.
#include "meshing/mesh/touching_edges.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace weft::meshing {
namespace {

using Edge = std::array<std::uint32_t, 2>;

Edge sorted_edge(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

std::vector<Edge> touching_edges(std::span<const Triangle> outer) {
  std::vector<Edge> sides;
  sides.reserve(3 * outer.size());
  for (const auto& t : outer)
    for (std::size_t i = 0; i < 3; ++i) sides.push_back(sorted_edge(t[i], t[(i + 1) % 3]));
  std::sort(sides.begin(), sides.end());
  return edges_of_several(sides);
}

}  // namespace

std::vector<Edge> edges_of_several(std::span<const Edge> sides) {
  std::vector<Edge> touching;
  for (std::size_t i = 2; i < sides.size(); ++i)
    if (sides[i] == sides[i - 2] && (touching.empty() || touching.back() != sides[i]))
      touching.push_back(sides[i]);
  return touching;
}

std::size_t require_touching_edges(std::span<const Triangle> outer, MeshData& boundary) {
  const std::vector<Edge> touching = touching_edges(outer);
  if (touching.empty()) return 0;
  std::vector<std::pair<Edge, std::uint32_t>> listed;
  for (std::uint32_t e = 0; e < boundary.edges.size(); ++e)
    listed.emplace_back(sorted_edge(boundary.edges[e][0], boundary.edges[e][1]), e);
  std::sort(listed.begin(), listed.end());
  for (const Edge& edge : touching) {
    const auto found = std::lower_bound(listed.begin(), listed.end(), std::pair{edge, 0u});
    if (found != listed.end() && found->first == edge) {
      boundary.required_edges.push_back(found->second);
      continue;
    }
    boundary.required_edges.push_back(static_cast<std::uint32_t>(boundary.edges.size()));
    boundary.edges.push_back(edge);
    boundary.edge_refs.push_back(0);
  }
  return touching.size();
}

std::string touching_edges_warning(std::size_t count) {
  return std::to_string(count) + " edges at which the mesh touches itself stay as they are";
}

}  // namespace weft::meshing

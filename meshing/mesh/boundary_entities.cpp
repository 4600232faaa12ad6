// Edges, lists and words of an input's boundary.
#include "meshing/mesh/boundary_entities.h"

#include <fmt/format.h>

#include <algorithm>

namespace weft::meshing {
namespace {

using Edge = std::array<std::uint32_t, 2>;

Edge edge_between(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

std::vector<Edge> sorted_sides(const std::vector<Triangle>& triangles) {
  std::vector<Edge> sides;
  sides.reserve(3 * triangles.size());
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) sides.push_back(edge_between(t[i], t[(i + 1) % 3]));
  std::sort(sides.begin(), sides.end());
  return sides;
}

void take_listed(const std::vector<std::uint32_t>& listed, const std::vector<std::uint32_t>& new_index,
                 std::vector<std::uint32_t>& taken) {
  for (const std::uint32_t i : listed)
    if (new_index[i] != kDropped) taken.push_back(new_index[i]);
}

}  // namespace

void take_boundary_edges(const MeshData& input, MeshData& boundary, std::vector<std::string>& warnings) {
  if (input.edges.empty()) return;
  const std::vector<Edge> sides = sorted_sides(boundary.triangles);
  std::vector<std::uint32_t> new_index(input.edges.size(), kDropped);
  for (std::size_t i = 0; i < input.edges.size(); ++i) {
    const auto [a, b] = input.edges[i];
    if (!std::binary_search(sides.begin(), sides.end(), edge_between(a, b))) continue;
    new_index[i] = static_cast<std::uint32_t>(boundary.edges.size());
    boundary.edges.push_back(input.edges[i]);
    boundary.edge_refs.push_back(input.edge_refs[i]);
  }
  take_listed(input.ridges, new_index, boundary.ridges);
  take_listed(input.required_edges, new_index, boundary.required_edges);
  if (boundary.edges.size() < input.edges.size())
    warnings.push_back(dropped_edges_warning(input.edges.size() - boundary.edges.size()));
}

void take_required_triangles(const MeshData& input, const std::vector<std::uint32_t>& new_index,
                             MeshData& boundary) {
  take_listed(input.required_triangles, new_index, boundary.required_triangles);
}

std::string repeated_triangles_warning(std::size_t count) {
  return fmt::format("{} repeated triangles were dropped", count);
}

std::string created_triangles_warning(std::size_t count) {
  return fmt::format("{} boundary or interface triangles were missing and have been created with reference 0",
                     count);
}

std::string dropped_edges_warning(std::size_t count) {
  return fmt::format("{} edges that lie on no boundary triangle were dropped", count);
}

std::string triangle_name(std::uint64_t index, const Triangle& v) {
  return fmt::format("triangle {} ({} {} {})", index + 1, std::uint64_t{v[0]} + 1, std::uint64_t{v[1]} + 1,
                     std::uint64_t{v[2]} + 1);
}

}  // namespace weft::meshing

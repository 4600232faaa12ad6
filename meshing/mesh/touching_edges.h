// Edges at which a body touches itself: several sets of tets that are not joined around the edge share it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Makes the edges of `boundary` that more than two of the triangles `outer` share, those with a tet on one
/// side only, required edges of it; they get reference 0 where it does not list them yet. An operator walks
/// round an edge from tet to tet and would change one of the sets only, so that the other would lose its
/// ridge. Returns how many there are. O(n log n).
std::size_t require_touching_edges(std::span<const Triangle> outer, MeshData& boundary);
/// Those of sorted sides of outer triangles that are there more than twice, each once.
std::vector<std::array<std::uint32_t, 2>> edges_of_several(
    std::span<const std::array<std::uint32_t, 2>> sorted_sides);
/// What a user is told of them.
std::string touching_edges_warning(std::size_t count);

}  // namespace weft::meshing

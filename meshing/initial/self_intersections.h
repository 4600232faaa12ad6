// Finds pairs of triangles that meet where they share nothing.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Pairs of triangles (first < second, ascending) that have more in common than shared vertices and edges:
/// the first `most` of them; few more are looked for. Exact, of triangles that are not degenerate; O(n log n)
/// for surfaces, multithreaded on TBB. Throws Interrupted once the flag, if any, is set.
std::vector<std::array<std::uint32_t, 2>> self_intersections(std::span<const Point> points,
                                                             std::span<const Triangle> triangles,
                                                             std::size_t most,
                                                             const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing

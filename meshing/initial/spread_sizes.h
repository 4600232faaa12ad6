// Sizes that spread from a surface through the volume inside it, not across gaps.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// A vertex whose size is given, and how fast sizes may grow away from it.
struct SizeSource {
  std::uint32_t vertex;
  double size, slope;
};

/// A size that has come from a source: the `way` to it is taken along edges.
struct SpreadSize {
  double size, way;
  std::uint32_t source;  ///< its number
};

/// The size at `to`, one edge from `from`, that comes from the same source, which stands at `origin`:
/// distances are at least Euclidean, at least 0.9 of the way along edges, which is as much too long in meshes
/// of good tets.
SpreadSize spread_on(const SpreadSize& from, const SizeSource& source, const Point& origin, double edge,
                     const Point& to);

/// A size at every vertex: a source's own; elsewhere the least of size + slope * distance over the sources,
/// the distance taken along edges of the mesh that do not pass through other sources. Infinite where no
/// source is reached. Time: one shortest-path search.
std::vector<SpreadSize> spread_sizes(const MeshData& mesh, std::span<const SizeSource> sources);

}  // namespace weft::meshing

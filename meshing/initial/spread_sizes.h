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

/// A size at every vertex: a source's own; elsewhere the least of size + slope * distance over the sources,
/// the distance taken along edges of the mesh that do not pass through other sources. Infinite where no
/// source is reached. Distances are at least Euclidean, at least 0.9 of the way along the edges, which is as
/// much too long in meshes of good tets. Time: one shortest-path search.
std::vector<double> spread_sizes(const MeshData& mesh, std::span<const SizeSource> sources);

}  // namespace weft::meshing

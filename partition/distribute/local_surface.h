// A rank's triangles of the boundary with two rings of others around them.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "partition/distribute/whole_boundary.h"

namespace weft::partition {

/// Vertices and triangles have the order that they have in the boundary.
struct LocalSurface {
  meshing::MeshData mesh;                ///< numbered by entries of `vertices`
  std::vector<std::uint32_t> triangles;  ///< numbers in the boundary, ascending
  std::vector<std::uint32_t> vertices;   ///< numbers in the whole input, ascending
  std::vector<std::uint8_t> rings;       ///< meshing::SurfaceTopology::rings
};

/// With these triangles (ascending) as its own. Of edges and lists it has what lies between its vertices.
LocalSurface local_surface(const WholeBoundary& boundary, const std::vector<std::uint32_t>& own);

}  // namespace weft::partition

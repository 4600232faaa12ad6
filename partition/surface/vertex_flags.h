// What a vertex's triangles, edges and lists make of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/vertex_kind.h"
#include "meshing/kernel/tet_mesh.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::partition {

/// meshing::VertexFlag of each vertex of a boundary, as meshing::import_mesh sets them. `kinds` by vertex,
/// `patch_of` by triangle.
inline std::vector<std::uint8_t> vertex_flags(const meshing::MeshData& boundary,
                                              std::span<const meshing::VertexKind> kinds,
                                              std::span<const meshing::PatchId> patch_of,
                                              std::span<const meshing::Patch> patches) {
  std::vector<std::uint8_t> all(boundary.points.size(), 0);
  const auto add = [&](std::uint32_t v, int flags) { all[v] = static_cast<std::uint8_t>(all[v] | flags); };
  for (std::uint32_t v = 0; v < all.size(); ++v)
    if (kinds[v] == meshing::VertexKind::corner) add(v, meshing::kFixed);
  for (std::uint32_t t = 0; t < boundary.triangles.size(); ++t)
    if (!patches[patch_of[t].value].planar)
      for (const std::uint32_t v : boundary.triangles[t]) add(v, meshing::kOnCurved);
  for (const std::uint32_t t : boundary.required_triangles)
    for (const std::uint32_t v : boundary.triangles[t]) add(v, meshing::kFixed);
  for (const std::uint32_t e : boundary.required_edges)
    for (const std::uint32_t v : boundary.edges[e]) add(v, meshing::kFixed);
  for (const std::uint32_t v : boundary.required_points) add(v, meshing::kFixed | meshing::kListedRequired);
  for (const std::uint32_t v : boundary.corners) add(v, meshing::kFixed | meshing::kListedCorner);
  return all;
}

}  // namespace weft::partition

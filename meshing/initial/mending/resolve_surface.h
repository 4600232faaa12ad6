// Mends of surfaces that cross themselves or are open: what bounds the volumes that they go around.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/repair/repair_mesh.h"

namespace weft::meshing {

/// For a surface that crosses itself or has free edges; others stay untouched. Triangles are turned alike,
/// cut along their crossings, and kept where the winding number says that a volume ends there: what is within
/// the union of the volumes goes. What then is open is closed between its borders by new triangles. Given
/// vertices stay where they are, but for merging within 1e-9 of the diagonal. The surface stays as it is, to
/// be refused, where that fails, where the new triangles would be more than a third of the others, or where
/// more than a quarter of the surface bounds nothing: it is an open sheet. Needles that cuts make are
/// avoided: new vertices that are nearer to others than a tenth of the triangles' edges there and 0.1 % of
/// the diagonal become one with them. `source` names each triangle. Returns why the surface was left as it
/// is; empty where it was mended, or needs no mending. Throws Interrupted once the flag, if any, is set.
std::string resolve_surface(MeshData& surface, std::vector<std::uint32_t>& source,
                            std::vector<MeshMend>& mends, const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing

// Mends of surfaces that bound no volume because they are open by a little.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/repair/repair_mesh.h"

namespace weft::meshing {

/// Closes what is nearly closed, in this order: vertices at the same place become one (close_surface() does
/// it too); vertices of free edges that are near each other, against the lengths of their edges, become one;
/// free edges that pass near a free vertex are split there; loops of free edges that are left, and small
/// against the surface, are filled with triangles of the least area. Triangles that are repeated or collapsed
/// are removed. What then is still open, or crosses itself, is resolved by winding numbers
/// (resolve_surface()), if it bounds volumes at all; else it stays so, and `left` says why. Pieces of listed
/// edges stay listed, with their references and marks. `source` is the number that each triangle had. Points
/// keep their numbers, new ones come behind them. Throws Interrupted once the flag, if any, is set; the
/// surface may be half mended.
std::vector<MeshMend> repair_surface(MeshData& surface, std::string* left = nullptr,
                                     const std::atomic<bool>* interrupt = nullptr,
                                     std::vector<std::uint32_t>* source = nullptr);

}  // namespace weft::meshing

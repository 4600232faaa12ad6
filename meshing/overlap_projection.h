// The conservative part of a transfer: L2 projection through the overlap of two meshes, bounded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/background.h"
#include "meshing/mesh_data.h"

namespace weft::meshing {

/// Values at vertices, several columns: column c of vertex v at v * columns + c.
struct ValueTable {
  std::size_t columns = 0;
  std::vector<double> values;
};

/// The integral over `mesh` of each column, linear in each tet.
std::vector<double> integrals(const MeshData& mesh, const ValueTable& table);

/// Replaces `table`, which holds the old values interpolated at the vertices of `to`, by their bounded L2
/// projection with the integrals `wanted` (see TransferMethod::conservative); `places` are tets of `from` at
/// the vertices of `to`. Returns how far each column had to leave its bounds. Throws InputError for a tet of
/// `to` without volume.
std::vector<double> project(const Background& from, const ValueTable& old, const MeshData& to,
                            std::span<const std::uint32_t> places, std::span<const double> wanted,
                            ValueTable& table);

}  // namespace weft::meshing

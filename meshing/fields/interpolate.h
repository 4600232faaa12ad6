// Fields of one mesh at the vertices of another.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/value_table.h"
#include "meshing/fields/tet_locator.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct Interpolation {
  SolutionData fields;        ///< of the same kinds and names as those given
  std::uint64_t outside = 0;  ///< vertices outside the mesh by more than 1e-6 of a tet's size
  double farthest = 0;        ///< largest distance of one of them from the mesh
};

/// Values read at points, and where.
struct ValuesAt {
  ValueTable table;
  std::vector<std::uint32_t> places;  ///< for each point the tet that it was read in
  std::vector<double> distances;      ///< of each point from the mesh
  std::vector<std::uint8_t> outside;  ///< whether by more than 1e-6 of a tet's size
};

/// Every field of `fields`, given at the vertices of `from`, at those of `to`: linear in each tet, exact for
/// linear fields; outside `from` the value at its closest point. Metrics are better read by logarithms: `weft
/// adapt` does that itself. Multithreaded on TBB; does not depend on the number of threads. About 1 us a
/// vertex where the vertices of `to` follow each other in space; memory: 66 bytes a tet of `from`. Throws
/// InputError naming the tet of `from` (1-based) that has no volume or is inverted, and for a `from` without
/// tets.
Interpolation interpolate(const MeshData& from, const SolutionData& fields, const MeshData& to);
/// The same for values at the vertices of the mesh in which points are located.
ValuesAt interpolate(const TetLocator& from, const ValueTable& table, std::span<const Point> points);
/// The value of each column at `place`, whose tet has these vertices.
void read_at(const TetLocator::Place& place, const std::array<std::uint32_t, 4>& tet, const ValueTable& table,
             double* values);
/// Throws InputError naming the first tet (1-based) that has no volume or is inverted.
void check_volumes(const MeshData& mesh);
/// To interpolate from. Throws as interpolate() does.
TetLocator locator_in(const MeshData& from);

/// All components of all fields, those of one vertex together.
ValueTable packed(const SolutionData& fields);
/// Puts the first columns of the table into `fields`, which have kinds and names.
void unpack(const ValueTable& table, SolutionData& fields);

/// The integral over `mesh` of each component of a field that is linear in each tet.
std::vector<double> integrals(const MeshData& mesh, const Field& field);

}  // namespace weft::meshing

// Which tets of a mesh planes across the axes cut.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::report {

/// Positions of planes across each of the three axes, ascending. At most 65,535 an axis.
using AxisPlanes = std::array<std::vector<double>, 3>;

/// For each plane, by axis and position, the tets that have a vertex in front of it (with a larger
/// coordinate) and one that has not, ascending. Indices must be in range. One pass over the tets.
/// Multithreaded on TBB (in the caller's arena); the result does not depend on the number of threads.
std::vector<std::vector<std::uint32_t>> cut_tets(const meshing::MeshData& mesh, const AxisPlanes& planes);

}  // namespace weft::report

// Mends of metrics that are none at some vertices.
#pragma once

#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/repair/repair_mesh.h"

namespace weft::meshing {

/// In the first tensor or scalar field of `solution`, at the vertices of `mesh`: tensors that are not finite
/// or not positive definite, and sizes that are not finite or not positive, become the log-Euclidean mean of
/// the neighbours' values that are good, nearest first. Throws InputError where none is good.
std::vector<MeshMend> repair_metric(const MeshData& mesh, SolutionData& solution);

}  // namespace weft::meshing

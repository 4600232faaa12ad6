// How a mesh lies on the CAD model of its surface, and what is recorded of that.
#pragma once

#include <vector>

#include "meshing/geometry/surface.h"
#include "meshing/kernel/tet_mesh.h"
#include "weft/data.h"

namespace weft::meshing {

/// Distances of boundary vertices from their entities, deviations of faces and edges. A vertex is off the
/// model beyond 1e-8 of the model's size and its entity's tolerance. `deviations`: where not null, the
/// distance of each boundary face's centroid from the model, in the order of export_mesh(). The surface has a
/// model.
ModelAccount account_on_model(const TetMesh& mesh, const Surface& surface,
                              std::vector<double>* deviations = nullptr);

/// The records for files, of the mesh as export_mesh() numbers it: every vertex with the node, the edges and
/// the faces that it lies on.
Association associate(const TetMesh& mesh, const Surface& surface);

}  // namespace weft::meshing

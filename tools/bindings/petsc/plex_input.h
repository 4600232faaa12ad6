// From a distributed DMPlex to the part of a mesh that each rank gives to weft.
#pragma once

#include <petscdmplex.h>

#include "weft/weft.h"

namespace weft::petsc {

struct PlexInput {
  Part part;
  Metric metric;
};

/// All ranks: the tets that the rank owns (of an overlap none twice), the faces of the boundary and those
/// within that `bd_label` has, with its values as references, regions by `rg_label`. `metric`: a local vector
/// as of DMPlexMetricCreate(). Either label may be null.
PetscErrorCode read_plex(DM dm, Vec metric, DMLabel bd_label, DMLabel rg_label, PlexInput& input);

/// All triangles of the mesh stay as they are.
void require_boundary(Mesh& mesh);

}  // namespace weft::petsc

// From a distributed DMPlex to the part of a mesh that each rank gives to weft.
#pragma once

#include <petscdmplex.h>

#include "tools/bindings/petsc/label_sets.h"
#include "weft/weft.h"

namespace weft::petsc {

struct PlexInput {
  Part part;
  Metric metric;
  LabelSets faces, regions;  ///< what references of triangles and tets stand for
};

/// All ranks: the tets that the rank owns (of an overlap none twice), the faces of the boundary and those
/// within that `bd_label` has, and regions by `rg_label`, with references as of references_of(). `metric`: a
/// local vector as of DMPlexMetricCreate(). Either label may be null.
PetscErrorCode read_plex(DM dm, Vec metric, DMLabel bd_label, DMLabel rg_label, PlexInput& input);

/// All triangles of the mesh stay as they are.
void require_boundary(Mesh& mesh);

}  // namespace weft::petsc

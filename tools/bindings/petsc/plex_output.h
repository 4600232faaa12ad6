// From the part of the adapted mesh that each rank has to a distributed DMPlex.
#pragma once

#include <petscdmplex.h>

#include "tools/bindings/petsc/label_sets.h"
#include "weft/weft.h"

namespace weft::petsc {

/// All ranks: a new, interpolated DMPlex with the options prefix of `old`, its point star forest, and the
/// labels that have the names of `bd_label` and `rg_label`, which may be null, with the values that the
/// references of triangles and tets stand for.
PetscErrorCode make_plex(DM old, const Part& part, DMLabel bd_label, const LabelSets& faces, DMLabel rg_label,
                         const LabelSets& regions, DM* made);

}  // namespace weft::petsc

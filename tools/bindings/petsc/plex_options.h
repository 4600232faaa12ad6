// The options that PETSc has for all adaptors, as weft's.
#pragma once

#include <petscdmplex.h>

#include "weft/weft.h"

namespace weft::petsc {

struct PlexOptions {
  Options weft;
  bool boundary_stays = false;  ///< -dm_plex_metric_no_surf
  PetscInt verbosity = -1;      ///< -dm_plex_metric_verbosity: 1 prints the summary
};

/// Those of `dm`, and -weft_threads and -weft_subdomains beside them. Fails for an option that weft has no
/// equal of.
PetscErrorCode options_of_plex(DM dm, PlexOptions& options);

}  // namespace weft::petsc

// Better neighbourhoods for the worst tets.
#pragma once

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing {

/// Gives the worst tets better neighbourhoods, with added points or without those that are.
void improve_tets(TetGrid& grid);

}  // namespace weft::meshing

// Makes a grid Delaunay again where something has changed it.
#pragma once

#include <atomic>

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing {

/// Flips faces whose two tets are not Delaunay, and what this makes, until no flip of two tets for three or
/// three for two is left that helps. Facets stay. Points must stand where doubles say. Ends early, with a
/// whole grid, once `interrupt` (unless null) is set. The same grid gives the same tets.
void flip_to_delaunay(TetGrid& grid, const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing

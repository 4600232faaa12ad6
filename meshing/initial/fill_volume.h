// From an initial grid to a mesh of good tets: the speculative kernel with an isotropic metric.
#pragma once

#include "meshing/adapt/adapt.h"
#include "meshing/initial/initial_grid.h"

namespace weft::meshing {

struct FillOptions {
  double growth = 1.3;          ///< of neighbouring edges away from the surface
  double size = 0;              ///< largest size; 0: no limit
  BackgroundData background;    ///< sizes to use instead of the surface's, where given
  bool remesh_surface = false;  ///< else the surface stays, triangle by triangle
  AdaptOptions adapt;
};

/// Fills the grid with points of the wanted density and improves the tets. With the surface kept, the result
/// has the grid's triangles, edges, ridges, corners and required entities.
AdaptResult fill_volume(const MeshData& grid, const FillOptions& options);

}  // namespace weft::meshing

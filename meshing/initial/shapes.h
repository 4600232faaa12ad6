// Surfaces of simple bodies to start from: `weft mesh ball` and its like.
#pragma once

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"
#include "weft/data.h"

namespace weft::meshing {

/// A sphere of triangles with edges of about `size`: a divided icosahedron, reference 1. Throws InputError
/// for sizes that ask for more points than 32-bit indices name.
MeshData ball_surface(const BallOptions& options);

/// An upright cylinder. References: 1 side, 2 lower end, 3 upper end; the end circles are ridges.
MeshData cylinder_surface(const CylinderOptions& options);

/// UGAWG's delta wing in its far-field box. References: 1 top, 2 bottom, 3 bevel, 4 back face, 5 x min, 6 x
/// max, 7 symmetry plane y = 0, 8 y max, 9 z min, 10 z max. Throws InputError as ball_surface() does.
MeshData delta_wing_surface(const DeltaWingOptions& options = {});

}  // namespace weft::meshing

// Surfaces of simple bodies to start from: `weft mesh ball` and its like.
#pragma once

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct BallOptions {
  Point center;
  double radius = 1, size = 0.1;
};
/// A sphere of triangles with edges of about `size`: a divided icosahedron, reference 1. Throws InputError
/// for sizes that ask for more points than 32-bit indices name.
MeshData ball_surface(const BallOptions& options);

struct CylinderOptions {
  Point base;  ///< centre of the lower end
  double radius = 1, height = 2, size = 0.1;
};
/// An upright cylinder. References: 1 side, 2 lower end, 3 upper end; the end circles are ridges.
MeshData cylinder_surface(const CylinderOptions& options);

struct DeltaWingOptions {
  double size = 0;  ///< longest edge on the wing; 0: as few triangles as there can be
};
/// UGAWG's delta wing in its far-field box. References: 1 top, 2 bottom, 3 bevel, 4 back face, 5 x min, 6 x
/// max, 7 symmetry plane y = 0, 8 y max, 9 z min, 10 z max. Throws InputError as ball_surface() does.
MeshData delta_wing_surface(const DeltaWingOptions& options = {});

}  // namespace weft::meshing

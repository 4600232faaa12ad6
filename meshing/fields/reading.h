// What a part of the new mesh of a pair reads from the old one.
#pragma once

#include <memory>

#include "meshing/base/value_table.h"
#include "meshing/fields/interpolate.h"
#include "meshing/fields/mesh_pair.h"
#include "meshing/fields/tet_locator.h"

namespace weft::meshing {

struct Reading {
  std::unique_ptr<const TetLocator> locator;  ///< of MeshPair::source; null: there is nothing to read
  ValueTable source;                          ///< at its vertices
  ValuesAt at;  ///< at the vertices of the part of the new mesh; places are tets of the source
};

/// The values of the old mesh, given at the vertices of its part, at those of the part of the new one: linear
/// in each tet, and beyond the mesh those of its closest point. All parts call together.
Reading read(MeshPair& meshes, const ValueTable& at_old);

}  // namespace weft::meshing

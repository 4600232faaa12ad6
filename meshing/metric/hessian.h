// Second derivatives of a field given at the vertices of a mesh.
#pragma once

#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// How derivatives are recovered from values at vertices.
enum class Recovery {
  /// A quadratic through the vertex, fitted by least squares to the vertices within two edges (more where
  /// these do not determine it): exact for quadratic fields, at the boundary too ("k-exact", Barth 1993).
  least_squares,
  /// Gradients of the tets averaged at vertices (the lumped L2 projection), twice; Hessians at boundary
  /// vertices are means of the nearest inside, because one-sided averages are wrong there by their own size.
  /// Smoother and cheaper.
  double_projection,
};

/// The Hessian of the field `values` (one a vertex, finite) at every vertex of `mesh`. Every vertex must
/// belong to a tet or gets zero. Multithreaded on TBB in the caller's arena; the result does not depend on
/// the number of threads. About 15 us a vertex by least_squares, 5 us by double_projection; temporaries of
/// 200 and 370 bytes a vertex. Throws InputError for tets whose vertices are out of range.
std::vector<SymTensor> recover_hessians(const MeshData& mesh, std::span<const double> values,
                                        Recovery recovery);

}  // namespace weft::meshing

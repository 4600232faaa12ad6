// Second derivatives of a field given at the vertices of a mesh.
#pragma once

#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"
#include "meshing/metric/metric_domain.h"
#include "weft/data.h"

namespace weft::meshing {

/// How many rings of tets around a vertex its Hessian may depend on.
int rings_of(HessianRecovery recovery);

/// The Hessian of the field `values` (one a vertex, finite) at every vertex of `mesh`. Every vertex must
/// belong to a tet or gets zero. Multithreaded on TBB in the caller's arena; the result does not depend on
/// the number of threads. About 15 us a vertex by least_squares, 5 us by double_projection; temporaries of
/// 200 and 370 bytes a vertex. Throws InputError for tets whose vertices are out of range.
/// On a part of a mesh: at all its vertices, from the rings of tets that rings_of() says around those it
/// owns.
std::vector<SymTensor> recover_hessians(const MetricDomain& domain, std::span<const double> values,
                                        HessianRecovery recovery);
std::vector<SymTensor> recover_hessians(const MeshData& mesh, std::span<const double> values,
                                        HessianRecovery recovery);

}  // namespace weft::meshing

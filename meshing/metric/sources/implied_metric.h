// The metric that a mesh already has: the one in which its tets are as unit as they can be.
#pragma once

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_domain.h"
#include "meshing/metric/metric_field.h"

namespace weft::meshing {

/// At every vertex the log-Euclidean mean, weighted by volumes, of its tets' metrics; a tet's metric is the
/// one in which its six edges have length 1. The complexity of the result is the mesh's own. Multithreaded;
/// does not depend on the number of threads. Memory: 16 bytes a tet. Throws InputError naming the tet
/// (1-based) that has no volume or is inverted. A vertex of no tet gets the bounding box's diagonal as size.
LogMetricField implied_metric(const MeshData& mesh);
/// On a part of a mesh: at all its vertices, from one ring of tets around those it owns.
LogMetricField implied_metric(const MetricDomain& domain);

}  // namespace weft::meshing

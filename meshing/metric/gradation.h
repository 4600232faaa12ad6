// Gradation: how fast the wanted size may grow along edges.
#pragma once

#include <cstdint>

#include "meshing/mesh/adjacency.h"
#include "meshing/metric/metric_domain.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// Limits the gradation of metric fields on one domain; the mesh's edges are found once.
class Gradation {
 public:
  /// `domain` must outlive the object; beta <= 1 asks for nothing. Memory: 60 bytes a vertex.
  Gradation(const MetricDomain& domain, double beta, GradationSpace space);
  /// Intersects every metric with what its neighbours demand, in sweeps over all vertices, each from the
  /// state before it (so that their order does not matter), until no metric falls short of that by more than
  /// 0.1 %: at most as many sweeps as a chain of edges is long, each over the vertices that the last one left
  /// to be looked at. Returns the number of sweeps that changed something: 0 where the field is graded
  /// already. Ends after a sweep, which counts, once the domain is interrupted. Memory: 110 bytes a vertex,
  /// in the mixed space twice that.
  int limit(LogMetricField& field) const;

 private:
  const MetricDomain& domain_;
  double beta_;
  GradationSpace space_;
  VertexLists neighbours_;
};

/// Gradation(WholeDomain(mesh), beta, space).limit(field).
int limit_gradation(const MeshData& mesh, double beta, LogMetricField& field,
                    GradationSpace space = GradationSpace::metric);

}  // namespace weft::meshing

// Gradation: how fast the wanted size may grow along edges.
#pragma once

#include <cstdint>

#include "meshing/mesh/adjacency.h"
#include "meshing/metric/metric_field.h"

namespace weft::meshing {

/// In which space sizes grow (Alauzet 2010). Going from p to q, d the Euclidean length of the
/// edge, l its length in M_p and lambda_i the eigenvalues of M_p, M_q must be at least as fine as M_p with
enum class GradationSpace {
  /// all eigenvalues over (1 + l ln beta)^2: the anisotropy stays;
  metric,
  /// lambda_i over the square of (1 + sqrt(lambda_i) d ln beta)^t (1 + l ln beta)^(1-t), t = 1/8: between the
  /// metric space and the physical one, where the metric becomes isotropic with distance.
  mixed,
};

/// Limits the gradation of metric fields on one mesh; the mesh's edges are found once.
class Gradation {
 public:
  /// `mesh` must outlive the object; beta <= 1 asks for nothing. Memory: 60 bytes a vertex.
  Gradation(const MeshData& mesh, double beta, GradationSpace space);
  /// Intersects every metric with what its neighbours demand, in sweeps over all vertices, each from the
  /// state before it (so that their order does not matter), until no metric falls short of that by more than
  /// 0.1 %, or 50 times. Returns the number of sweeps that changed something: 0 where the field is graded
  /// already. Memory: 110 bytes a vertex, in the mixed space twice that.
  int limit(LogMetricField& field) const;

 private:
  const MeshData& mesh_;
  double beta_;
  GradationSpace space_;
  VertexLists neighbours_;
};

/// Gradation(mesh, beta, space).limit(field).
int limit_gradation(const MeshData& mesh, double beta, LogMetricField& field,
                    GradationSpace space = GradationSpace::metric);

}  // namespace weft::meshing

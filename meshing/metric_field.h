// A metric at every vertex of a mesh: from a file's field, an analytic formula, or the mesh itself;
// scaled, limited and graded. All processing of the metric happens here, before adaptation.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "meshing/mesh_data.h"
#include "meshing/metric.h"

namespace weft::meshing {

/// One LogMetric a vertex: the form in which metrics are averaged, interpolated and scaled.
using LogMetricField = std::vector<LogMetric>;

/// All functions here are multithreaded on TBB (in the caller's arena); no result depends on the number of
/// threads.

/// Reads the metric out of a solution: the first tensor or scalar (isotropic size h, metric h^-2) field.
/// Throws InputError naming `file` and the vertex (1-based) when a value is NaN or infinite, a size is not
/// positive, or a tensor is not positive definite (saying so when the row-wise order m11 m12 m13 m22 m23 m33
/// would be definite everywhere), or when the number of vertices differs from `num_points` ("metric of
/// another mesh").
LogMetricField metric_from_solution(const SolutionData& solution, std::size_t num_points,
                                    const std::string& file);
/// The other way: a tensor field to write.
SolutionData solution_from_metric(std::span<const LogMetric> log_metrics);

LogMetricField sample(const AnalyticMetric& metric, const MeshData& mesh);

/// M <- (target/C)^(2/3) M, so that the complexity on `mesh` becomes `target`.
void scale_to_complexity(const MeshData& mesh, double target, LogMetricField& field);
/// The same with sizes limited to [hmin, hmax] (0: none): M <- limit_sizes(s M) with the one factor s for
/// which the complexity is right, or the s that comes closest where the limits forbid it. Returns the
/// complexity reached.
double scale_to_complexity(const MeshData& mesh, double target, double hmin, double hmax,
                           LogMetricField& field);
/// limit_sizes of every metric. Throws InputError when hmin > hmax > 0.
void limit_sizes(double hmin, double hmax, LogMetricField& field);
/// Gradation in metric space (Alauzet 2010): along every edge the metric may grow by at most the factor
/// `beta` per unit length: M_q <- intersect(M_q, (1 + l_p(pq) ln beta)^-2 M_p), l_p the length in M_p. Sweeps
/// over all vertices, each from the state before it (so that their order does not matter), until no metric
/// falls short of that by more than 0.1 %, or 50 times. Returns the number of sweeps that changed something:
/// 0 where the field is graded already, or beta <= 1, which asks for nothing.
int limit_gradation(const MeshData& mesh, double beta, LogMetricField& field);

}  // namespace weft::meshing

// A metric at every vertex of a mesh: from a file's field, an analytic formula, or the mesh itself;
// scaled, limited, intersected (gradation.h grades it). All processing of the metric happens here, before
// adaptation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// One LogMetric a vertex: the form in which metrics are averaged, interpolated and scaled.
using LogMetricField = std::vector<LogMetric>;

/// All functions here are multithreaded on TBB (in the caller's arena); no result depends on the number of
/// threads.

/// Reads the metric out of a solution: the first tensor or scalar (isotropic size h, metric h^-2) field.
/// Throws InputError naming `file` and the vertex (1-based) when a value is NaN or infinite, a size is not
/// positive, or a tensor is not positive definite (saying so when the row-wise order m11 m12 m13 m22 m23 m33
/// would be definite everywhere), or when the number of vertices differs from `num_points` ("metric of
/// another mesh"). `first`: the number of the first vertex, for messages.
LogMetricField metric_from_solution(const SolutionData& solution, std::size_t num_points,
                                    const std::string& file, std::uint64_t first = 0);
/// The other way: a tensor field to write.
SolutionData solution_from_metric(std::span<const LogMetric> log_metrics);

/// The size where nothing is asked for: the diagonal of the mesh's bounding box, 1 for a mesh without any.
double largest_size(const MeshData& mesh);

LogMetricField sample(const AnalyticMetric& metric, const MeshData& mesh);

/// M <- (target/C)^(2/3) M, so that the complexity on `mesh` becomes `target`.
void scale_to_complexity(const MeshData& mesh, double target, LogMetricField& field);
/// The same with sizes limited to [hmin, hmax] (0: none): M <- limit_sizes(s M) with the one factor s for
/// which the complexity is right, or the s that comes closest where the limits forbid it. Returns the
/// complexity reached.
double scale_to_complexity(const MeshData& mesh, double target, double hmin, double hmax,
                           LogMetricField& field);
/// Limits of the eigenvalues of log M, from those of the sizes (0: none). Throws InputError when hmin > hmax
/// > 0.
struct LogSizeLimits {
  double lo, hi;
  LogSizeLimits(double hmin, double hmax);
  double operator()(double v) const { return std::clamp(v, lo, hi); }
  bool none() const { return std::isinf(lo) && std::isinf(hi); }
};
/// limit_sizes of every metric. Throws InputError when hmin > hmax > 0.
void limit_sizes(double hmin, double hmax, LogMetricField& field);
/// Brings the sizes of every metric down to at most `ratio` times its smallest: 1 makes it isotropic. Below
/// 1: no limit.
void limit_aspect(double ratio, LogMetricField& field);
/// Makes every metric as fine as itself and the other field's metric at its vertex (intersect()).
void intersect_with(const LogMetricField& other, LogMetricField& field);

}  // namespace weft::meshing

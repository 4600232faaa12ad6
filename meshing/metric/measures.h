// Measures of a mesh in its metric, by the exact formulas: what reports and `weft stat` print.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"
#include "weft/data.h"

namespace weft::meshing {

/// Measures `mesh` in the vertex metrics `log_metrics` (logarithms, one a vertex). Quantile q is the smallest
/// quality that at least the share q of the tets do not exceed. All zero without tets. Multithreaded on TBB
/// (uses the arena it is called in); the result does not depend on the number of threads.
Measures measure(const MeshData& mesh, std::span<const LogMetric> log_metrics);

/// Complexity alone: sum of sqrt(det M_i) V_i over the vertices.
double complexity(const MeshData& mesh, std::span<const LogMetric> log_metrics);

/// All zero without tets.
ShapeMeasures measure_shape(const MeshData& mesh);

/// Mean ratio of one tet in the log-Euclidean mean of its vertices' metrics: 36 / 3^(1/3) (V sqrt(det
/// M))^(2/3) over the sum of its squared edge lengths; 1 for a regular unit tet, negative for an inverted
/// one.
double mean_ratio(const std::array<Point, 4>& points, const std::array<LogMetric, 4>& log_metrics);

}  // namespace weft::meshing

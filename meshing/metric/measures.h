// Measures of a mesh in its metric, by the exact formulas: what reports and `weft stat` print.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Counts in equal intervals of [lo, hi] (of log10 of the value where `logarithmic`); outside values go
/// into `below` and `above`, the value hi into the last interval.
struct Histogram {
  double lo = 0, hi = 1;
  bool logarithmic = false;
  std::vector<std::uint64_t> counts;
  std::uint64_t below = 0, above = 0;

  void add(double value);
  /// Adds the counts of a histogram of the same intervals.
  Histogram& operator+=(const Histogram& other);
};

struct Measures {
  std::uint64_t num_vertices = 0, num_tets = 0, num_edges = 0, num_triangles = 0;
  double volume = 0;
  double complexity = 0;  ///< sum over vertices of sqrt(det M) times a quarter of the volumes of its tets
  // Mean ratio of the tets, in the log-Euclidean mean of the four vertices' metrics.
  double quality_mean = 0, quality_min = 0, quality_q01 = 0,
         quality_q001 = 0;  ///< q01: 1 % quantile, q001: 0.1 %
  double quality_below_01 = 0, quality_below_02 = 0, quality_above_08 = 0;  ///< shares
  // Edge lengths in the metric, each edge once.
  double length_mean = 0, length_min = 0, length_max = 0;
  double edges_unit = 0, edges_short = 0, edges_long = 0;  ///< shares; unit: [1/sqrt 2, sqrt 2]
  Histogram quality{0, 1, false, std::vector<std::uint64_t>(100), 0, 0};
  Histogram quality_log{-4, 0, true, std::vector<std::uint64_t>(80), 0, 0};
  Histogram length{0, 4, false, std::vector<std::uint64_t>(80), 0, 0};
  Histogram length_log{-1.5, 1.5, true, std::vector<std::uint64_t>(60), 0, 0};
};

/// Measures `mesh` in the vertex metrics `log_metrics` (logarithms, one a vertex). Quantile q is the smallest
/// quality that at least the share q of the tets do not exceed. All zero without tets. Multithreaded on TBB
/// (uses the arena it is called in); the result does not depend on the number of threads.
Measures measure(const MeshData& mesh, std::span<const LogMetric> log_metrics);

/// Complexity alone: sum of sqrt(det M_i) V_i over the vertices.
double complexity(const MeshData& mesh, std::span<const LogMetric> log_metrics);

/// Shapes of the tets as they are, without a metric.
struct ShapeMeasures {
  double quality_mean = 0, quality_min = 0, quality_q01 = 0;  ///< mean ratio; q01: 1 % quantile
  double least_dihedral_degrees = 0;                          ///< smallest angle between two faces of a tet
};

/// All zero without tets.
ShapeMeasures measure_shape(const MeshData& mesh);

/// Mean ratio of one tet in the log-Euclidean mean of its vertices' metrics: 36 / 3^(1/3) (V sqrt(det
/// M))^(2/3) over the sum of its squared edge lengths; 1 for a regular unit tet, negative for an inverted
/// one.
double mean_ratio(const std::array<Point, 4>& points, const std::array<LogMetric, 4>& log_metrics);

}  // namespace weft::meshing

// Measures of a mesh that was made from one that has been measured: what is in both is not measured twice.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/measure_totals.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// What stands for a tet that is not of the mesh before.
inline constexpr std::uint32_t kNoOrigin = 0xFFFFFFFFu;

/// A mesh and its metric.
struct MetricMeshView {
  const MeshData& mesh;
  std::span<const LogMetric> log_metrics;
};

/// The sums over a mesh, with its lowest qualities and the edges that are not unit: from these the sums over
/// one that differs in some tets follow. Multithreaded on TBB; does not depend on the number of threads.
class MeasuredMesh {
 public:
  explicit MeasuredMesh(const MetricMeshView& mesh);

  const Measures& measures() const { return measures_; }

  /// Measures of `result`. Tet i of it is, with its vertices, their places and their metrics, tet origins[i]
  /// of `old`, the mesh that was measured, or kNoOrigin; origins ascend, and what vertices both have come in
  /// the same order in both. Those of measure() but for rounding of sums. Empty where so much differs that
  /// nothing is gained, or the sums of `old` do not tell the extremes.
  std::optional<Measures> of_result(const MetricMeshView& old, const MetricMeshView& result,
                                    std::span<const std::uint32_t> origins) const;

 private:
  Measures measures_;
  TetTotals tets_;
  EdgeTotals edges_;
  std::vector<double> lowest_;  ///< qualities, ascending: all up to the last of these
  std::vector<double> odd_;  ///< lengths of all edges that are not unit, ascending; empty where they are many
};

}  // namespace weft::meshing

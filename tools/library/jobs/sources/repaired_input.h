// An input that is mended before it is used, with what belongs to its vertices.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshing/mesh/repair/repair_mesh.h"
#include "meshing/metric/metric_field.h"
#include "weft/weft.h"

namespace weft::tools {

std::vector<Mend> mends_of(std::span<const meshing::MeshMend> mends);

/// The fields at the points of a mended mesh (MeshRepair::points).
Fields fields_at(const Fields& fields, const std::vector<std::uint32_t>& points);

/// Mends the mesh that was read from `file` (empty: it is a caller's), and the metric and solutions in the
/// files of `options` that belong to its vertices: they are in `options` (solutions) and the result (the
/// metric) then, and no more files. `fields` and solutions in memory follow. Throws InputError for what
/// cannot be mended.
struct RepairedMetric {
  std::optional<meshing::LogMetricField> source;
  std::vector<Mend> mends;
  std::vector<std::uint32_t> points;  ///< MeshRepair::points
};
RepairedMetric repair_input(meshing::MeshData& mesh, const std::string& file, MetricOptions& options,
                            Fields& fields);
/// The same of a background, whose mends say so.
RepairedMetric repair_background(meshing::MeshData& mesh, const std::string& file, MetricOptions& options);

}  // namespace weft::tools

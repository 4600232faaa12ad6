// Adaptation of one mesh in memory: metric, prediction of memory, kernel, measures, fields.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "meshing/geometry/model/model.h"
#include "meshing/metric/metric_field.h"
#include "tools/library/jobs/monitor.h"
#include "weft/weft.h"

namespace weft::tools {

/// Where the run starts. Names are those of files, empty for data that never were in one.
struct AdaptInput {
  const meshing::MeshData& mesh;
  std::string name;
  const meshing::MeshData* background = nullptr;  ///< that the metric belongs to; null: `mesh`
  std::string background_name;
  const meshing::LogMetricField* metric = nullptr;  ///< a source besides those of the options
  const meshing::SolutionData& fields;              ///< at the vertices of `mesh`, to be carried along
  /// Unless null, gets the CAD model that the mesh lies on, if any.
  std::shared_ptr<const meshing::Model>* model = nullptr;
  meshing::MeshData* own = nullptr;  ///< `mesh`, where that may be taken for the result
};

/// Throws InputError. Times of reading and writing, the total and the goals' asking are left to the caller.
Result adapt_one(const AdaptInput& input, const Options& options, Monitor& monitor);

/// Whether a mesh that fits its metric is what these options want: not by RunOptions::force. What vertices on
/// a model lie like is to be accounted for; a distance from the surface that the metric does not know of is
/// to be kept.
bool may_stay(const Options& options);

/// Refuses a run that cannot fit, in words that name the complexity: throws InputError.
void check_size(const std::string& name, double complexity, const RunOptions& run, const MeshCounts& input,
                SizePrediction& predicted);

/// The same of a run in `parts` on `ranks` of which the one with the least room has `room`.
void check_size_of_parts(const std::string& name, double complexity, const RunOptions& run,
                         const MeshCounts& input, std::uint32_t parts, int ranks, std::optional<double> room,
                         SizePrediction& predicted);

}  // namespace weft::tools

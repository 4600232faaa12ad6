// The metric that options ask for: all sources intersected, scaled, limited and graded.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "meshing/geometry/model.h"
#include "meshing/metric/metric_field.h"
#include "meshing/metric/metric_limits.h"
#include "weft/weft.h"

namespace weft::tools {

meshing::MetricLimits limits_of(const MetricOptions& options);
/// The files that the metric is read from.
std::vector<std::string> files_of(const MetricOptions& options);
/// Files and functions, for reports.
std::string name_of(const MetricOptions& options);
bool has_demand(const MetricOptions& options);
/// Whether a given metric, a file or a function is scaled and nothing else: what each rank can do with its
/// share.
bool scaled_alone(const MetricOptions& options);

struct LogMetricMade {
  meshing::LogMetricField field;
  std::vector<std::string> warnings;  ///< for the user
};
/// The metric asked for, at the vertices of `mesh`, which errors call `mesh_name`: all that is given
/// (`source` too, where not null), intersected, and scaled so that it has the complexity once it is as fine
/// as the boundary demands, limited and graded. Metrics of solutions come in with that complexity, or with
/// the mesh's own where none is requested. Curvature is that of `model`, where not null. Throws InputError
/// naming file, entity and reason.
LogMetricMade make_log_metric(const MetricOptions& options, const meshing::MeshData& mesh,
                              const std::string& mesh_name, const meshing::LogMetricField* source = nullptr,
                              std::shared_ptr<const meshing::Model> model = nullptr);

}  // namespace weft::tools

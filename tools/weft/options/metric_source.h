// Where a command's metric comes from and what is done to it before use.
#pragma once

#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/boundary_metric.h"
#include "meshing/metric/metric_field.h"
#include "meshing/metric/metric_limits.h"
#include "meshing/metric/multiscale.h"

namespace CLI {
class App;
}

namespace weft::tools {

struct MetricRequest {
  // Sources; what is asked for in all of them is intersected.
  std::string file;                    ///< --metric
  std::string function;                ///< --metric-fn
  std::vector<std::string> solutions;  ///< --sol
  meshing::MultiscaleOptions multiscale;
  bool implied = false;  ///< --implied
  // Demands of the boundary, which --complexity does not scale where there is a source too.
  meshing::CurvatureOptions curvature;
  meshing::WallOptions wall;

  double complexity = 0;  ///< 0: as the metric is
  meshing::MetricLimits limits;

  bool has_source() const { return !file.empty() || !function.empty() || !solutions.empty() || implied; }
  bool has_demand() const { return curvature.per_turn > 0 || curvature.sagitta > 0 || !wall.refs.empty(); }
  bool given() const { return has_source() || has_demand(); }
  /// The files and functions, for reports.
  std::string name() const;
  /// The files it reads.
  std::vector<std::string> files() const;
};

/// Declares --metric and --metric-fn, which exclude each other.
void add_metric_source(CLI::App& command, MetricRequest& request);
/// Declares what makes a metric: --sol with its options, --implied, --curvature, --sagitta, --wall.
void add_metric_construction(CLI::App& command, MetricRequest& request);
/// Declares --complexity, --hmin, --hmax, --aspect, --hgrad and --hgrad-space.
void add_metric_processing(CLI::App& command, MetricRequest& request);
/// Throws CLI::ValidationError when the options contradict each other.
void check_request(const MetricRequest& request);

struct MadeMetric {
  meshing::LogMetricField field;
  std::vector<std::string> warnings;  ///< for the user
};
/// The metric asked for, at the vertices of `mesh`, which was read from `mesh_file`: all that is given,
/// intersected, and scaled so that it has the complexity once it is as fine as the boundary demands, limited
/// and graded. Metrics of solutions come in with that complexity, or with the mesh's own where none is
/// requested. Throws InputError naming file, entity and reason.
MadeMetric make_metric(const MetricRequest& request, const meshing::MeshData& mesh,
                       const std::string& mesh_file);

}  // namespace weft::tools

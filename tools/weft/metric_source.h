// Where a command's metric comes from and what is done to it before use.
#pragma once

#include <string>
#include <vector>

#include "meshing/mesh_data.h"
#include "meshing/metric_field.h"

namespace CLI {
class App;
}

namespace weft::tools {

struct MetricRequest {
  std::string file;                           ///< --metric
  std::string function;                       ///< --metric-fn
  double complexity = 0, hmin = 0, hmax = 0;  ///< 0: as the metric is
  double hgrad = 0;                           ///< up to 1: no gradation
  bool given() const { return !file.empty() || !function.empty(); }
  std::string name() const { return file.empty() ? function : file; }
};

/// Declares --metric and --metric-fn, which exclude each other.
void add_metric_source(CLI::App& command, MetricRequest& request);
/// Declares --complexity, --hmin, --hmax and --hgrad.
void add_metric_processing(CLI::App& command, MetricRequest& request);
/// Throws CLI::ValidationError when the options contradict each other.
void check_request(const MetricRequest& request);

/// The metric as given, at the vertices of `mesh`.
meshing::LogMetricField load_metric(const MetricRequest& request, const meshing::MeshData& mesh);

/// Sizes limited, gradation limited, then scaled, in this order, so that it is the complexity that is met in
/// the end. Returns warnings for the user.
std::vector<std::string> process_metric(const MetricRequest& request, const meshing::MeshData& mesh,
                                        meshing::LogMetricField& field);

}  // namespace weft::tools

// The metric that options ask for: all sources intersected, scaled, limited and graded.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/metric/metric_domain.h"
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
/// None where curvature is not asked.
std::optional<meshing::CurvatureOptions> curvature_options(const MetricOptions& options);
/// Makes `current` what it and `more` ask for together.
void combine(meshing::LogMetricField&& more, std::optional<meshing::LogMetricField>& current);
/// What the boundary of the mesh asks for, or nothing where it was not asked.
std::optional<meshing::LogMetricField> boundary_demand(const MetricOptions& options,
                                                       const meshing::MeshData& mesh,
                                                       std::shared_ptr<const meshing::Model> model);
/// Whether a given metric, a file or a function is scaled and nothing else: what each rank can do with its
/// share.
bool scaled_alone(const MetricOptions& options);

/// How near to a curved boundary edges must stay, where the metric is limited to what that bears.
struct SurfaceBound {
  double hausd = 0;  ///< 0: the default
  double ridge_angle_degrees = meshing::kRidgeAngle;
  /// Of the curvature of a boundary that edges of length 1 lie on with half of that for their sagitta; of a
  /// mesh of this size.
  meshing::CurvatureOptions curvature(double size_of_mesh) const;
};
/// What options and the boundary of the mesh mean: none where they leave the metric as it is, or the boundary
/// is planar, as far as its triangles tell, and not a model's.
std::optional<SurfaceBound> surface_bound(const GeometryOptions& options, const meshing::MeshData& mesh);

/// Where a metric is made, and what is given there.
struct MetricInputs {
  const meshing::MetricDomain& domain;
  /// Values of a file's fields, and the metric in a file, at the vertices of the domain.
  std::function<Fields(const std::string& file)> read_fields;
  std::function<meshing::LogMetricField(const std::string& file)> read_metric;
  /// What curvature and walls ask for at the vertices of the domain; nothing where nothing is asked.
  std::function<std::optional<meshing::LogMetricField>()> boundary_demand;
  /// What a curved boundary needs at the vertices of the domain; nothing where there is no bound.
  std::function<std::optional<meshing::LogMetricField>()> surface_demand;
  const meshing::LogMetricField* source = nullptr;  ///< one more metric, where not null
};

struct LogMetricMade {
  meshing::LogMetricField field;
  std::vector<std::string> warnings;  ///< for the user
  meshing::SurfaceLimit surface_limit = {};
  double complexity = 0;  ///< reached, where one is asked for; 0 where the run was ended meanwhile
};
/// The metric asked for, at the vertices of the domain, which errors call `mesh_name`: all that is given,
/// intersected, and scaled so that it has the complexity once it is as fine
/// as the boundary demands, limited and graded; where a curved boundary bears no edges as long as that, once
/// more with what it bears (surface_limit.h). Metrics of solutions come in with that complexity, or with
/// the mesh's own where none is requested. Curvature is that of `model`, where not null. All parts of a mesh
/// call together; what they read must be without faults then. Once the domain is interrupted limits and
/// gradation are left as they are, which is among the warnings. Throws InputError naming file, entity and
/// reason.
LogMetricMade make_log_metric(const MetricOptions& options, const MetricInputs& inputs,
                              const std::string& mesh_name);
/// The same of a whole mesh, with the limit of its surface where there is a bound.
LogMetricMade make_log_metric(const MetricOptions& options, const meshing::MeshData& mesh,
                              const std::string& mesh_name, const meshing::LogMetricField* source = nullptr,
                              std::shared_ptr<const meshing::Model> model = nullptr,
                              const std::optional<SurfaceBound>& bound = {},
                              const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::tools

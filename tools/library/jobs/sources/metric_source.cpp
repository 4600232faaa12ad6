// Reads, makes and processes the sources of a metric.
#include "tools/library/jobs/sources/metric_source.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/sources/curvature_metric.h"
#include "meshing/metric/sources/implied_metric.h"
#include "meshing/metric/sources/multiscale.h"
#include "meshing/metric/sources/wall_metric.h"
#include "tools/common/naming.h"
#include "tools/common/text.h"

namespace weft::tools {
namespace {

/// What `current` and `more` ask for together.
void combine(meshing::LogMetricField&& more, std::optional<meshing::LogMetricField>& current) {
  if (current)
    meshing::intersect_with(more, *current);
  else
    current = std::move(more);
}

/// What the metrics of solutions are scaled to.
double solution_complexity(const MetricOptions& options, const meshing::MeshData& mesh) {
  return options.complexity > 0 ? options.complexity
                                : meshing::complexity(mesh, meshing::implied_metric(mesh));
}

/// The intersection of the multiscale metrics of all scalar fields, each of the complexity `target`.
void add_solution(const MetricOptions& options, const Fields& solution, const std::string& file,
                  const meshing::MeshData& mesh, double target,
                  std::optional<meshing::LogMetricField>& field) {
  for (const auto& values : meshing::scalar_fields(solution, mesh.points.size(), file)) {
    meshing::LogMetricField metric =
        meshing::multiscale_metric(mesh, values, {options.recovery, options.norm});
    meshing::scale_to_complexity(mesh, target, metric);
    combine(std::move(metric), field);
  }
}

/// What the boundary asks for, or nothing where it was not asked.
std::optional<meshing::LogMetricField> boundary_demand(const MetricOptions& options,
                                                       const meshing::MeshData& mesh,
                                                       std::shared_ptr<const meshing::Model> model) {
  std::optional<meshing::LogMetricField> field;
  if (options.curvature > 0 || options.sagitta > 0) {
    meshing::CurvatureOptions curvature;
    curvature.per_turn = options.curvature;
    curvature.sagitta = options.sagitta;
    combine(meshing::curvature_metric(mesh, curvature, std::move(model)), field);
  }
  if (!options.wall.refs.empty()) combine(meshing::wall_metric(mesh, options.wall), field);
  return field;
}

/// What the files, the formula and the solutions ask for, or nothing where there are none.
std::optional<meshing::LogMetricField> given_metric(const MetricOptions& options,
                                                    const meshing::MeshData& mesh,
                                                    const meshing::LogMetricField* source) {
  std::optional<meshing::LogMetricField> field;
  const std::size_t n = mesh.points.size();
  if (source) field = *source;
  if (!options.function.empty())
    combine(meshing::sample(meshing::AnalyticMetric(options.function), mesh), field);
  if (!options.file.empty())
    combine(meshing::metric_from_solution(meshing::read_solution(options.file), n, options.file), field);
  const bool resolves = !options.sol.empty() || !options.solutions.empty();
  const double target = resolves ? solution_complexity(options, mesh) : 0;
  for (const std::string& file : options.sol)
    add_solution(options, meshing::read_solution(file), file, mesh, target, field);
  for (const Fields& solution : options.solutions) add_solution(options, solution, "", mesh, target, field);
  return field;
}

/// Returns the complexity reached.
double scale(const MetricOptions& options, const meshing::MeshData& mesh,
             const meshing::LogMetricField* demands, meshing::LogMetricField& field) {
  const meshing::MetricLimits limits = limits_of(options);
  const bool only_sizes = !demands && !(limits.gradation > 1) && !(limits.aspect >= 1);
  if (only_sizes)
    return meshing::scale_to_complexity(mesh, options.complexity, limits.hmin, limits.hmax, field);
  return meshing::fit_to_complexity(mesh, options.complexity, limits, demands, field);
}

/// Scaled to the complexity, as fine as `demands`, limited and graded, so that it is the complexity that is
/// met in the end. Returns warnings for the user.
std::vector<std::string> process(const MetricOptions& options, const meshing::MeshData& mesh,
                                 const std::optional<meshing::LogMetricField>& demands,
                                 meshing::LogMetricField& field) {
  constexpr double kComplexityTolerance = 0.01;
  if (options.complexity <= 0) {
    if (demands) meshing::intersect_with(*demands, field);
    meshing::apply_limits(mesh, limits_of(options), field);
    return {};
  }
  const double reached = scale(options, mesh, demands ? &*demands : nullptr, field);
  if (std::abs(reached / options.complexity - 1) <= kComplexityTolerance) return {};
  return {fmt::format("limits and boundary sizes lead to a complexity of {} instead of {}", grouped(reached),
                      grouped(options.complexity))};
}

}  // namespace

meshing::MetricLimits limits_of(const MetricOptions& options) {
  return {options.hmin, options.hmax, options.aspect, options.hgrad, options.hgrad_space};
}

std::vector<std::string> files_of(const MetricOptions& options) {
  std::vector<std::string> all = options.sol;
  if (!options.file.empty()) all.insert(all.begin(), options.file);
  return all;
}

bool has_demand(const MetricOptions& options) {
  return options.curvature > 0 || options.sagitta > 0 || !options.wall.refs.empty();
}

bool scaled_alone(const MetricOptions& options) {
  const bool limited = options.hmin > 0 || options.hmax > 0 || options.aspect > 0 || options.hgrad > 1;
  return !limited && options.sol.empty() && options.solutions.empty() && !options.implied &&
         !has_demand(options);
}

std::string name_of(const MetricOptions& options) {
  std::vector<std::string> parts = files_of(options);
  if (!options.function.empty()) parts.push_back(options.function);
  if (!options.solutions.empty()) parts.emplace_back("solution");
  if (options.implied) parts.emplace_back("implied");
  if (options.curvature > 0 || options.sagitta > 0) parts.emplace_back("curvature");
  if (!options.wall.refs.empty()) parts.emplace_back("wall");
  return fmt::format("{}", fmt::join(parts, " + "));
}

LogMetricMade make_log_metric(const MetricOptions& options, const meshing::MeshData& mesh,
                              const std::string& mesh_name, const meshing::LogMetricField* source,
                              std::shared_ptr<const meshing::Model> model) {
  std::optional<meshing::LogMetricField> field = given_metric(options, mesh, source);
  return naming(mesh_name, [&]() -> LogMetricMade {
    if (options.implied) combine(meshing::implied_metric(mesh), field);
    std::optional<meshing::LogMetricField> demands = boundary_demand(options, mesh, std::move(model));
    if (!field) field = std::exchange(demands, std::nullopt);
    if (!field) throw InputError("", "", "no metric is given");
    std::vector<std::string> warnings = process(options, mesh, demands, *field);
    return {std::move(*field), std::move(warnings)};
  });
}

}  // namespace weft::tools

// Reads, makes and processes the sources of a metric.
#include "tools/library/jobs/sources/metric_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/geometry/surface/face_directions.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/expectations.h"
#include "meshing/metric/metric.h"
#include "meshing/metric/sources/curvature_metric.h"
#include "meshing/metric/sources/implied_metric.h"
#include "meshing/metric/sources/multiscale.h"
#include "meshing/metric/sources/wall_metric.h"
#include "meshing/metric/surface_limit.h"
#include "tools/common/naming.h"
#include "tools/common/text.h"

namespace weft::tools {
namespace {

/// What the metrics of solutions are scaled to.
double solution_complexity(const MetricOptions& options, const meshing::MetricDomain& domain) {
  return options.complexity > 0 ? options.complexity : domain.complexity(meshing::implied_metric(domain));
}

/// Where a solution does not vary in a direction, its metric asks for edges longer than the domain, whose
/// density no mesh can have: the complexity then counts vertices that cannot be left out, and what there is
/// of it goes to needles in the others.
bool asks_for_more_than_the_domain(const meshing::MetricDomain& domain,
                                   const meshing::LogMetricField& field) {
  const double least = -2 * std::log(domain.largest_size());
  bool any = false;
  for (const meshing::LogMetric& log_metric : field)
    any = any || meshing::eigen_decomposition(log_metric).values[0] < least;
  return domain.any(any);
}

/// What the files, the formula and the solutions ask for.
struct GivenMetric {
  std::optional<meshing::LogMetricField> field;  ///< empty where there are none
  double hmax = 0;                               ///< which solutions ask to exceed; 0: none does
};

/// Adds the multiscale metrics of all scalar fields, each of the complexity `target`.
void add_solution(const MetricOptions& options, const Fields& solution, const std::string& file,
                  const meshing::MetricDomain& domain, double target, GivenMetric& given) {
  for (const auto& values : meshing::scalar_fields(solution, domain.mesh().points.size(), file)) {
    meshing::LogMetricField metric =
        meshing::multiscale_metric(domain, values, {options.recovery, options.norm});
    meshing::scale_to_complexity(domain, target, metric);
    if (options.hmax == 0 && asks_for_more_than_the_domain(domain, metric)) {
      given.hmax = std::max(domain.largest_size(), options.hmin);
      meshing::scale_to_complexity(domain, target, 0, given.hmax, metric);
    }
    combine(std::move(metric), given.field);
  }
}

GivenMetric given_metric(const MetricOptions& options, const MetricInputs& inputs) {
  GivenMetric given;
  const meshing::MetricDomain& domain = inputs.domain;
  if (inputs.source) given.field = *inputs.source;
  if (!options.function.empty())
    combine(meshing::sample(meshing::AnalyticMetric(options.function), domain.mesh()), given.field);
  if (!options.file.empty()) combine(inputs.read_metric(options.file), given.field);
  const bool resolves = !options.sol.empty() || !options.solutions.empty();
  const double target = resolves ? solution_complexity(options, domain) : 0;
  for (const std::string& file : options.sol)
    add_solution(options, inputs.read_fields(file), file, domain, target, given);
  for (const Fields& solution : options.solutions)
    add_solution(options, solution, "solutions", domain, target, given);
  return given;
}

constexpr const char* kDemandsAlone =
    "the boundary's sizes are not as asked for: with no other metric beside them they are scaled to the "
    "complexity";

LogMetricMade cut(LogMetricMade made) {
  made.warnings = {"the metric need not be as asked for: the run was ended while it was made"};
  made.complexity = 0;
  return made;
}

/// What takes no sweeps and no trials.
bool limits_sizes_alone(const meshing::MetricLimits& limits, const meshing::LogMetricField* demands) {
  return !demands && !(limits.gradation > 1) && !(limits.aspect >= 1);
}

/// Returns the complexity reached.
double scale(const MetricOptions& options, const meshing::MetricDomain& domain,
             const meshing::LogMetricField* demands, meshing::LogMetricField& field) {
  const meshing::MetricLimits limits = limits_of(options);
  if (limits_sizes_alone(limits, demands))
    return meshing::scale_to_complexity(domain, options.complexity, limits.hmin, limits.hmax, field);
  return meshing::fit_to_complexity(domain, options.complexity, limits, demands, field);
}

/// `given`, scaled to the complexity, as fine as `demands`, limited and graded, so that it is the complexity
/// that is met in the end.
LogMetricMade process(const MetricOptions& options, const meshing::MetricDomain& domain,
                      const std::optional<meshing::LogMetricField>& demands, meshing::LogMetricField given) {
  constexpr double kComplexityTolerance = 0.01;
  const meshing::LogMetricField* more = demands ? &*demands : nullptr;
  LogMetricMade made{std::move(given), {}};
  if (options.complexity > 0) {
    made.complexity = scale(options, domain, more, made.field);
  } else {
    if (more) meshing::intersect_with(*more, made.field);
    meshing::apply_limits(domain, limits_of(options), made.field);
  }
  if (!limits_sizes_alone(limits_of(options), more) && domain.interrupted()) return cut(std::move(made));
  if (!(options.complexity > 0)) return made;
  if (std::abs(made.complexity / options.complexity - 1) <= kComplexityTolerance) return made;
  made.warnings = {fmt::format("limits and boundary sizes lead to a complexity of {} instead of {}",
                               grouped(made.complexity), grouped(options.complexity))};
  return made;
}

/// The same where a curved boundary limits what may be asked for.
LogMetricMade within_surface(const MetricOptions& options, const meshing::MetricDomain& domain,
                             std::optional<meshing::LogMetricField> demands,
                             meshing::LogMetricField of_surface, meshing::LogMetricField given) {
  LogMetricMade made = process(options, domain, demands, given);
  if (domain.interrupted()) return cut(std::move(made));
  // A complexity that is asked for stays in reach.
  constexpr double kMostOfComplexity = 0.5, kAny = std::numeric_limits<double>::infinity();
  auto limit = meshing::limit_of_surface(domain, std::move(of_surface), made.field,
                                         options.complexity > 0 ? kMostOfComplexity : kAny);
  if (!limit) return made;
  combine(std::move(limit->demand), demands);
  made.field = {};
  made = process(options, domain, demands, std::move(given));
  made.surface_limit = limit->account;
  return made;
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

std::optional<meshing::CurvatureOptions> curvature_options(const MetricOptions& options) {
  if (!(options.curvature > 0) && !(options.sagitta > 0)) return std::nullopt;
  meshing::CurvatureOptions curvature;
  curvature.per_turn = options.curvature;
  curvature.sagitta = options.sagitta;
  return curvature;
}

void combine(meshing::LogMetricField&& more, std::optional<meshing::LogMetricField>& current) {
  if (current)
    meshing::intersect_with(more, *current);
  else
    current = std::move(more);
}

meshing::CurvatureOptions SurfaceBound::curvature(double size_of_mesh) const {
  meshing::CurvatureOptions options;
  options.sagitta = 0.5 * (hausd > 0 ? hausd : meshing::kHausdOfDiagonal * size_of_mesh);
  options.ridge_angle_degrees = ridge_angle_degrees;
  return options;
}

std::optional<SurfaceBound> surface_bound(const GeometryOptions& options, const meshing::MeshData& mesh) {
  const bool binds =
      options.limit_metric && (!options.model.empty() || meshing::may_curve(mesh, options.ridge_angle));
  return binds ? std::optional(SurfaceBound{options.hausd, options.ridge_angle}) : std::nullopt;
}

std::optional<meshing::LogMetricField> boundary_demand(const MetricOptions& options,
                                                       const meshing::MeshData& mesh,
                                                       std::shared_ptr<const meshing::Model> model) {
  std::optional<meshing::LogMetricField> field;
  if (const auto curvature = curvature_options(options))
    combine(meshing::curvature_metric(mesh, *curvature, std::move(model)), field);
  if (!options.wall.refs.empty()) combine(meshing::wall_metric(mesh, options.wall), field);
  return field;
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

LogMetricMade make_log_metric(const MetricOptions& options, const MetricInputs& inputs,
                              const std::string& mesh_name) {
  auto [field, hmax] = given_metric(options, inputs);
  return naming(mesh_name, [&, &field = field, hmax = hmax]() -> LogMetricMade {
    MetricOptions limited = options;
    if (hmax > 0) limited.hmax = hmax;
    if (options.implied) combine(meshing::implied_metric(inputs.domain), field);
    std::optional<meshing::LogMetricField> demands = inputs.boundary_demand();
    const bool demands_alone = !field && options.complexity > 0;
    if (!field) field = std::exchange(demands, std::nullopt);
    if (!field) throw InputError("", "", "no metric is given");
    std::optional<meshing::LogMetricField> of_surface =
        inputs.surface_demand ? inputs.surface_demand() : std::nullopt;
    LogMetricMade made = of_surface ? within_surface(limited, inputs.domain, std::move(demands),
                                                     std::move(*of_surface), std::move(*field))
                                    : process(limited, inputs.domain, demands, std::move(*field));
    if (demands_alone) made.warnings.emplace_back(kDemandsAlone);
    return made;
  });
}

LogMetricMade make_log_metric(const MetricOptions& options, const meshing::MeshData& mesh,
                              const std::string& mesh_name, const meshing::LogMetricField* source,
                              std::shared_ptr<const meshing::Model> model,
                              const std::optional<SurfaceBound>& bound, const std::atomic<bool>* interrupt) {
  const meshing::WholeDomain domain(mesh, interrupt);
  const auto read_metric = [&](const std::string& file) {
    return meshing::metric_from_solution(meshing::read_solution(file), mesh.points.size(), file);
  };
  const auto demand = [&] { return boundary_demand(options, mesh, model); };
  const auto of_surface = [&]() -> std::optional<meshing::LogMetricField> {
    if (!bound) return std::nullopt;
    return meshing::curvature_metric(mesh, bound->curvature(domain.largest_size()), model);
  };
  return make_log_metric(options, {domain, meshing::read_solution, read_metric, demand, of_surface, source},
                         mesh_name);
}

}  // namespace weft::tools

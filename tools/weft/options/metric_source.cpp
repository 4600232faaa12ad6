// Options of the metric, and the calls that load and process it.
#include "tools/weft/options/metric_source.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/implied_metric.h"
#include "meshing/metric/measures.h"
#include "tools/weft/jobs/named_error.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/terminal/text.h"

namespace weft::tools {
namespace {

constexpr const char* kGroup = "Metric";

/// Empty when the name is one of an analytic metric, else what is wrong: a wrong name is a wrong command
/// line.
std::string check_metric_name(const std::string& name) {
  try {
    meshing::AnalyticMetric{name};
    return {};
  } catch (const meshing::InputError& error) {
    return error.what();
  }
}

void add_positive(CLI::App& command, const char* name, double& value, const char* text, const char* type,
                  const char* group) {
  command.add_option(name, value, text)->type_name(type)->check(positive_number())->group(group);
}

/// What `current` and `more` ask for together.
void combine(meshing::LogMetricField&& more, std::optional<meshing::LogMetricField>& current) {
  if (current)
    meshing::intersect_with(more, *current);
  else
    current = std::move(more);
}

/// What the metrics of solutions are scaled to.
double solution_complexity(const MetricRequest& request, const meshing::MeshData& mesh) {
  return request.complexity > 0 ? request.complexity
                                : meshing::complexity(mesh, meshing::implied_metric(mesh));
}

/// The intersection of the multiscale metrics of all scalar fields, each of the complexity `target`.
void add_solution(const MetricRequest& request, const std::string& file, const meshing::MeshData& mesh,
                  double target, std::optional<meshing::LogMetricField>& field) {
  const meshing::SolutionData solution = meshing::read_solution(file);
  for (const auto& values : meshing::scalar_fields(solution, mesh.points.size(), file)) {
    meshing::LogMetricField metric = meshing::multiscale_metric(mesh, values, request.multiscale);
    meshing::scale_to_complexity(mesh, target, metric);
    combine(std::move(metric), field);
  }
}

/// What the boundary asks for, or nothing where it was not asked.
std::optional<meshing::LogMetricField> boundary_demand(const MetricRequest& request,
                                                       const meshing::MeshData& mesh) {
  std::optional<meshing::LogMetricField> field;
  if (request.curvature.per_turn > 0 || request.curvature.sagitta > 0)
    combine(meshing::curvature_metric(mesh, request.curvature), field);
  if (!request.wall.refs.empty()) combine(meshing::wall_metric(mesh, request.wall), field);
  return field;
}

/// What the files and the formula ask for, or nothing where there are none.
std::optional<meshing::LogMetricField> given_metric(const MetricRequest& request,
                                                    const meshing::MeshData& mesh) {
  std::optional<meshing::LogMetricField> field;
  const std::size_t n = mesh.points.size();
  if (!request.function.empty()) field = meshing::sample(meshing::AnalyticMetric(request.function), mesh);
  if (!request.file.empty())
    field = meshing::metric_from_solution(meshing::read_solution(request.file), n, request.file);
  const double target = request.solutions.empty() ? 0 : solution_complexity(request, mesh);
  for (const std::string& file : request.solutions) add_solution(request, file, mesh, target, field);
  return field;
}

/// Returns the complexity reached.
double scale(const MetricRequest& request, const meshing::MeshData& mesh,
             const meshing::LogMetricField* demands, meshing::LogMetricField& field) {
  const meshing::MetricLimits& limits = request.limits;
  const bool only_sizes = !demands && !(limits.gradation > 1) && !(limits.aspect >= 1);
  if (only_sizes)
    return meshing::scale_to_complexity(mesh, request.complexity, limits.hmin, limits.hmax, field);
  return meshing::fit_to_complexity(mesh, request.complexity, limits, demands, field);
}

/// Scaled to the complexity, as fine as `demands`, limited and graded, so that it is the complexity that is
/// met in the end. Returns warnings for the user.
std::vector<std::string> process(const MetricRequest& request, const meshing::MeshData& mesh,
                                 const std::optional<meshing::LogMetricField>& demands,
                                 meshing::LogMetricField& field) {
  constexpr double kComplexityTolerance = 0.01;
  if (request.complexity <= 0) {
    if (demands) meshing::intersect_with(*demands, field);
    meshing::apply_limits(mesh, request.limits, field);
    return {};
  }
  const double reached = scale(request, mesh, demands ? &*demands : nullptr, field);
  if (std::abs(reached / request.complexity - 1) <= kComplexityTolerance) return {};
  return {fmt::format("limits and boundary sizes lead to a complexity of {} instead of {}", grouped(reached),
                      grouped(request.complexity))};
}

}  // namespace

void add_metric_source(CLI::App& command, MetricRequest& request) {
  auto* file =
      command
          .add_option("--metric", request.file, "metric tensors or sizes, .solb or .sol (also -met, -sol)")
          ->type_name("FILE")
          ->group(kGroup);
  command.add_option("--metric-fn", request.function, "analytic metric: polar-1, polar-2, linear, uniform:H")
      ->type_name("NAME")
      ->check(CLI::Validator(check_metric_name, ""))
      ->excludes(file)
      ->group(kGroup);
}

void add_metric_construction(CLI::App& command, MetricRequest& request) {
  static const std::map<std::string, meshing::Recovery> recoveries = {
      {"lsq", meshing::Recovery::least_squares}, {"l2", meshing::Recovery::double_projection}};
  constexpr const char* kSolution = "Metric from a solution";
  constexpr const char* kBoundary = "Metric from mesh and boundary";
  auto* solution =
      command
          .add_option("--sol", request.solutions,
                      "solution, .solb or .sol: all its scalar fields drive the metric; repeatable")
          ->type_name("FILE")
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
          ->group(kSolution);
  command
      .add_option("--norm", request.multiscale.norm,
                  "p of the Lp norm of the interpolation error, 1 to inf; default 2")
      ->type_name("P")
      ->check(number_from_one())
      ->needs(solution)
      ->group(kSolution);
  command
      .add_option("--recovery", request.multiscale.recovery,
                  "second derivatives by least squares (lsq, default) or L2 projection (l2)")
      ->transform(CLI::CheckedTransformer(recoveries).description(""))
      ->type_name("NAME")
      ->needs(solution)
      ->group(kSolution);
  command.add_flag("--implied", request.implied, "the metric in which the input mesh is unit")
      ->group(kBoundary);
  add_positive(command, "--curvature", request.curvature.per_turn,
               "edges per full turn of curvature of the boundary", "N", kBoundary);
  add_positive(command, "--sagitta", request.curvature.sagitta,
               "largest distance from an edge's midpoint to the curved boundary", "D", kBoundary);
  auto* wall = command
                   .add_option("--wall", request.wall.refs,
                               "references of walls with thin boundary layers, separated by commas")
                   ->type_name("REF,...")
                   ->delimiter(',')
                   ->expected(1)
                   ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
                   ->group(kBoundary);
  auto* height =
      command
          .add_option("--wall-height", request.wall.height, "size normal to the walls, of the first layer")
          ->type_name("H")
          ->check(positive_number())
          ->needs(wall)
          ->group(kBoundary);
  wall->needs(height);
  command
      .add_option("--wall-growth", request.wall.growth,
                  "growth ratio of successive layers, >= 1; default 1.2")
      ->type_name("G")
      ->check(number_from_one())
      ->check(finite_number())
      ->needs(wall)
      ->group(kBoundary);
  command.add_option("--wall-size", request.wall.tangential, "size along the walls; default: unrestricted")
      ->type_name("H")
      ->check(positive_number())
      ->needs(wall)
      ->group(kBoundary);
}

void add_metric_processing(CLI::App& command, MetricRequest& request) {
  static const std::map<std::string, meshing::GradationSpace> spaces = {
      {"metric", meshing::GradationSpace::metric}, {"mixed", meshing::GradationSpace::mixed}};
  meshing::MetricLimits& limits = request.limits;
  add_positive(command, "--complexity", request.complexity,
               "scale the metric to this complexity, about half the number of vertices", "C", kGroup);
  add_positive(command, "--hmin", limits.hmin, "smallest size of the metric (also -hmin)", "H", kGroup);
  add_positive(command, "--hmax", limits.hmax, "largest size of the metric (also -hmax)", "H", kGroup);
  add_positive(command, "--aspect", limits.aspect, "largest ratio of sizes at a vertex; 1: isotropic", "A",
               kGroup);
  command
      .add_option("--hgrad", limits.gradation,
                  "growth of sizes per unit edge; values <= 1 disable gradation (also -hgrad)")
      ->type_name("BETA")
      ->check(finite_number())
      ->group(kGroup);
  command
      .add_option("--hgrad-space", limits.space,
                  "space of gradation: metric (default, preserves anisotropy) or mixed")
      ->transform(CLI::CheckedTransformer(spaces).description(""))
      ->type_name("SPACE")
      ->group(kGroup);
}

void check_request(const MetricRequest& request) {
  const meshing::MetricLimits& limits = request.limits;
  if (limits.hmin > 0 && limits.hmax > 0 && limits.hmin > limits.hmax)
    throw CLI::ValidationError("--hmin", "is larger than --hmax");
  if (limits.aspect > 0 && limits.aspect < 1) throw CLI::ValidationError("--aspect", "is below 1");
}

std::vector<std::string> MetricRequest::files() const {
  std::vector<std::string> all = solutions;
  if (!file.empty()) all.insert(all.begin(), file);
  return all;
}

std::string MetricRequest::name() const {
  std::vector<std::string> parts = files();
  if (!function.empty()) parts.push_back(function);
  if (implied) parts.emplace_back("implied");
  if (curvature.per_turn > 0 || curvature.sagitta > 0) parts.emplace_back("curvature");
  if (!wall.refs.empty()) parts.emplace_back("wall");
  return fmt::format("{}", fmt::join(parts, " + "));
}

MadeMetric make_metric(const MetricRequest& request, const meshing::MeshData& mesh,
                       const std::string& mesh_file) {
  std::optional<meshing::LogMetricField> field = given_metric(request, mesh);
  return naming(mesh_file, [&]() -> MadeMetric {
    if (request.implied) combine(meshing::implied_metric(mesh), field);
    std::optional<meshing::LogMetricField> demands = boundary_demand(request, mesh);
    if (!field) field = std::exchange(demands, std::nullopt);
    std::vector<std::string> warnings = process(request, mesh, demands, *field);
    return {std::move(*field), std::move(warnings)};
  });
}

}  // namespace weft::tools

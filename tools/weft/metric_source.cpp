// Options of the metric, and the calls that load and process it.
#include "tools/weft/metric_source.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "meshing/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/measures.h"
#include "tools/weft/option_checks.h"
#include "tools/weft/text.h"

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

}  // namespace

void add_metric_source(CLI::App& command, MetricRequest& request) {
  auto* file =
      command.add_option("--metric", request.file, "metric or wanted sizes, .solb or .sol (also -met, -sol)")
          ->type_name("FILE")
          ->group(kGroup);
  command.add_option("--metric-fn", request.function, "analytic metric: polar-1, polar-2, linear, uniform:H")
      ->type_name("NAME")
      ->check(CLI::Validator(check_metric_name, ""))
      ->excludes(file)
      ->group(kGroup);
}

void add_metric_processing(CLI::App& command, MetricRequest& request) {
  command
      .add_option("--complexity", request.complexity,
                  "scale the metric to this complexity: about half the result's vertices")
      ->type_name("C")
      ->check(positive_number())
      ->group(kGroup);
  command.add_option("--hmin", request.hmin, "smallest size the metric may ask for (also -hmin)")
      ->type_name("H")
      ->check(positive_number())
      ->group(kGroup);
  command.add_option("--hmax", request.hmax, "largest size the metric may ask for (also -hmax)")
      ->type_name("H")
      ->check(positive_number())
      ->group(kGroup);
  command
      .add_option("--hgrad", request.hgrad,
                  "largest growth of sizes per unit edge; none up to 1 (also -hgrad)")
      ->type_name("BETA")
      ->check(finite_number())
      ->group(kGroup);
}

void check_request(const MetricRequest& request) {
  if (request.hmin > 0 && request.hmax > 0 && request.hmin > request.hmax)
    throw CLI::ValidationError("--hmin", "is larger than --hmax");
}

meshing::LogMetricField load_metric(const MetricRequest& request, const meshing::MeshData& mesh) {
  if (!request.function.empty()) return meshing::sample(meshing::AnalyticMetric(request.function), mesh);
  return meshing::metric_from_solution(meshing::read_solution(request.file), mesh.points.size(),
                                       request.file);
}

std::vector<std::string> process_metric(const MetricRequest& request, const meshing::MeshData& mesh,
                                        meshing::LogMetricField& field) {
  constexpr double kComplexityTolerance = 0.01;
  if (request.hmin > 0 || request.hmax > 0) meshing::limit_sizes(request.hmin, request.hmax, field);
  if (request.hgrad > 1) meshing::limit_gradation(mesh, request.hgrad, field);
  if (request.complexity <= 0) return {};
  const double reached =
      meshing::scale_to_complexity(mesh, request.complexity, request.hmin, request.hmax, field);
  if (std::abs(reached / request.complexity - 1) <= kComplexityTolerance) return {};
  return {fmt::format("--hmin and --hmax allow a complexity of {} only, {} was asked for", grouped(reached),
                      grouped(request.complexity))};
}

}  // namespace weft::tools

// Declares the options of metrics.
#include "tools/weft/options/metric_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>

#include "tools/weft/options/option_checks.h"

namespace weft::tools {
namespace {

constexpr const char* kGroup = "Metric";

/// Empty when the name is one of an analytic metric, else what is wrong: a wrong name is a wrong command
/// line.
std::string check_metric_name(const std::string& name) {
  Options options;
  options.metric.function = name;
  try {
    validate(options);
    return {};
  } catch (const OptionError& error) {
    return error.reason();
  }
}

void add_positive(CLI::App& command, const char* name, double& value, const char* text, const char* type,
                  const char* group) {
  command.add_option(name, value, text)->type_name(type)->check(positive_number())->group(group);
}

}  // namespace

void add_metric_source(CLI::App& command, MetricOptions& options) {
  auto* file =
      command
          .add_option("--metric", options.file, "metric tensors or sizes, .solb or .sol (also -met, -sol)")
          ->type_name("FILE")
          ->group(kGroup);
  command.add_option("--metric-fn", options.function, "analytic metric: polar-1, polar-2, linear, uniform:H")
      ->type_name("NAME")
      ->check(CLI::Validator(check_metric_name, ""))
      ->excludes(file)
      ->group(kGroup);
}

void add_metric_construction(CLI::App& command, MetricOptions& options) {
  static const std::map<std::string, HessianRecovery> recoveries = {
      {"lsq", HessianRecovery::least_squares}, {"l2", HessianRecovery::double_projection}};
  constexpr const char* kSolution = "Metric from a solution";
  constexpr const char* kBoundary = "Metric from mesh and boundary";
  auto* solution =
      command
          .add_option("--sol", options.sol,
                      "solution, .solb or .sol: all its scalar fields drive the metric; repeatable")
          ->type_name("FILE")
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
          ->group(kSolution);
  command
      .add_option("--norm", options.norm, "p of the Lp norm of the interpolation error, 1 to inf; default 2")
      ->type_name("P")
      ->check(number_from_one())
      ->needs(solution)
      ->group(kSolution);
  command
      .add_option("--recovery", options.recovery,
                  "second derivatives by least squares (lsq, default) or L2 projection (l2)")
      ->transform(one_of(recoveries))
      ->type_name("NAME")
      ->needs(solution)
      ->group(kSolution);
  command.add_flag("--implied", options.implied, "the metric in which the input mesh is unit")
      ->group(kBoundary);
  add_positive(command, "--curvature", options.curvature, "edges per full turn of curvature of the boundary",
               "N", kBoundary);
  add_positive(command, "--sagitta", options.sagitta,
               "largest distance from an edge's midpoint to the curved boundary", "D", kBoundary);
  auto* wall = command
                   .add_option("--wall", options.wall.refs,
                               "references of walls with thin boundary layers, separated by commas")
                   ->type_name("REF,...")
                   ->delimiter(',')
                   ->expected(1)
                   ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
                   ->group(kBoundary);
  auto* height =
      command
          .add_option("--wall-height", options.wall.height, "size normal to the walls, of the first layer")
          ->type_name("H")
          ->check(positive_number())
          ->needs(wall)
          ->group(kBoundary);
  wall->needs(height);
  command
      .add_option("--wall-growth", options.wall.growth,
                  "growth ratio of successive layers, >= 1; default 1.2")
      ->type_name("G")
      ->check(number_from_one())
      ->check(finite_number())
      ->needs(wall)
      ->group(kBoundary);
  command.add_option("--wall-size", options.wall.tangential, "size along the walls; default: unrestricted")
      ->type_name("H")
      ->check(positive_number())
      ->needs(wall)
      ->group(kBoundary);
}

void add_metric_processing(CLI::App& command, MetricOptions& options) {
  static const std::map<std::string, GradationSpace> spaces = {{"metric", GradationSpace::metric},
                                                               {"mixed", GradationSpace::mixed}};
  add_positive(command, "--complexity", options.complexity,
               "scale the metric to this complexity, about half the number of vertices", "C", kGroup);
  add_positive(command, "--hmin", options.hmin, "smallest size of the metric (also -hmin)", "H", kGroup);
  add_positive(command, "--hmax", options.hmax,
               "largest size of the metric (also -hmax); default for solutions: the diagonal", "H", kGroup);
  add_positive(command, "--aspect", options.aspect, "largest ratio of sizes at a vertex; 1: isotropic", "A",
               kGroup);
  command
      .add_option("--hgrad", options.hgrad,
                  "growth of sizes per unit edge; values <= 1 disable gradation (also -hgrad)")
      ->type_name("BETA")
      ->check(finite_number())
      ->group(kGroup);
  command
      .add_option("--hgrad-space", options.hgrad_space,
                  "space of gradation: metric (default, preserves anisotropy) or mixed")
      ->transform(one_of(spaces))
      ->type_name("SPACE")
      ->group(kGroup);
}

}  // namespace weft::tools

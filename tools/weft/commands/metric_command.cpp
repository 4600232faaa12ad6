// `weft metric`: makes a metric, limits, grades and scales it, without adapting to it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tools/common/inputs.h"
#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/metric_options.h"
#include "tools/weft/options/model_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/on_ranks.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kMetricFooter = R"(Examples:
  weft metric wing.meshb --sol mach.solb --complexity 50000 --hgrad 1.5 -o metric.solb
  weft metric cube.meshb --metric-fn polar-2 --complexity 50000 -o cube.solb
  weft metric wing.meshb --curvature 24 --geometry wing.step -o wing.solb
  weft metric pipe.meshb --curvature 24 --wall 1,2 --wall-height 1e-4 --hgrad 1.5 -o layers.solb

All metrics given are intersected. The sources (--metric, --metric-fn, --sol, --implied) are scaled so that
the result has the --complexity after intersection with the boundary sizes (--curvature, --sagitta, --wall),
which are not scaled unless they are all that is given, and after limits and gradation.)";

struct MetricCommand {
  std::string mesh, output;
  MetricOptions metric;
  GeometryOptions geometry;
  int threads = 1;
  Verbosity verbosity;
};

void tell(const MetricCommand& command, const std::vector<std::string>& warnings, std::uint64_t vertices,
          double complexity) {
  for (const std::string& warning : warnings) command.verbosity.print("warning: {}\n", warning);
  command.verbosity.print("{}: metric at {}, complexity {}\n", command.output, counted(vertices, "vertex"),
                          grouped(complexity));
}

int run_on_ranks(const MetricCommand& command) {
  const MetricOnRanks done =
      write_metric_on_ranks(command.mesh, command.metric, command.output, command.geometry, command.threads);
  if (done.first) tell(command, done.warnings, done.vertices, done.complexity);
  return kDone;
}

int run_metric(const MetricCommand& command) {
  if (!command.metric.given()) throw CLI::RequiredError(kNoMetric, CLI::ExitCodes::RequiredError);
  keep_inputs(command.output, "it", {command.metric.file});
  keep_inputs(command.output, "it", command.metric.sol);
  if (under_mpirun()) return run_on_ranks(command);
  check_writable(command.output);
  Progress progress(command.verbosity.style());
  progress.phase("reading");
  const Mesh mesh = read_mesh(command.mesh);
  progress.phase("metric");
  const auto [metric, warnings] =
      make_metric(mesh, command.metric, command.geometry, command.mesh, command.threads);
  progress.phase("writing");
  write_fields(command.output, metric.fields());
  progress.finish();
  tell(command, warnings, metric.size(), complexity(mesh, metric));
  return kDone;
}

}  // namespace

void add_metric_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand(
      "metric", "make a metric from a solution, a mesh or a formula; limit, grade, scale it");
  sub->footer(kMetricFooter);
  auto command = std::make_shared<MetricCommand>();
  sub->add_option("MESH", command->mesh, "the mesh")->type_name("FILE")->required();
  sub->add_option("-o,-x,--out", command->output, "the metric, .solb or .sol (also -out)")
      ->type_name("FILE")
      ->check(solution_name())
      ->required();
  add_metric_source(*sub, command->metric);
  add_metric_construction(*sub, command->metric);
  add_metric_processing(*sub, command->metric);
  add_model(*sub, command->geometry);
  add_threads(*sub, command->threads);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_metric(*command); }; });
}

}  // namespace weft::tools

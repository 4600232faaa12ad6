// `weft adapt`: the main job, from files to files.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "tools/weft/adapt_job.h"
#include "tools/weft/commands.h"
#include "tools/weft/option_checks.h"
#include "tools/weft/summary.h"

namespace weft::tools {
namespace {

constexpr const char* kFooter = R"(Examples:
  weft adapt wing.meshb --sol mach.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --metric wing.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --sol mach.solb --field flow.solb --transfer conservative -o fine.meshb
  weft adapt cube.meshb --metric-fn polar-2 -o layer.meshb --threads 2 --report report

Writes the mesh and, beside it, the metric at its vertices (fine.solb) and the fields carried along
(fine-fields.solb); each whole or not at all.
--metric holds a symmetric tensor (m11 m12 m22 m13 m23 m33) or a wanted size at every vertex of the
input, or of --background; --sol a solution whose interpolation error is to be least. The metric is scaled
so that it has the --complexity once it is limited (--hmin, --hmax, --aspect) and graded (--hgrad); expect
about 2 vertices and 12 tets a unit of complexity. Ctrl-C ends the run with the valid mesh reached so far
and exit code 1.)";

struct AdaptCommand : AdaptRequest {
  bool quiet = false;
};

int run(AdaptCommand& command) {
  if (!command.metric.given())
    throw CLI::RequiredError(
        "no metric: give --metric FILE or --sol FILE (.solb or .sol) or --metric-fn NAME (such as polar-2)",
        CLI::ExitCodes::RequiredError);
  check_request(command.metric);
  if (command.quiet) command.progress = ProgressStyle::none;
  const AdaptOutcome outcome = run_adapt(command);
  if (!command.quiet) fmt::print("{}", summary_text(outcome.run));
  return outcome.code;
}

void add_files(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("IN", command.input, "the mesh to adapt")->type_name("FILE")->required();
  sub.add_option("-o,-x,--out", command.output, "the result (also -out)")
      ->type_name("FILE")
      ->check(volume_output_name())
      ->required();
}

void add_background(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("--background", command.background,
                 "the mesh that the metric belongs to; default: the input")
      ->type_name("FILE")
      ->group("Metric");
}

void add_geometry(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("--ridge-angle", command.options.ridge_angle_degrees,
                 "keep boundary edges sharper than this; default 45 (also -ar)")
      ->type_name("DEG")
      ->check(CLI::Range(0.0, 180.0).description(""))
      ->group("Geometry");
  sub.add_option("--hausd", command.options.hausd,
                 "largest distance to the surface; default 0.1 % of the diagonal (also -hausd)")
      ->type_name("D")
      ->check(positive_number())
      ->group("Geometry");
}

void add_run(CLI::App& sub, AdaptCommand& command) {
  static const std::map<std::string, ProgressStyle> styles = {
      {"auto", ProgressStyle::automatic}, {"plain", ProgressStyle::plain}, {"none", ProgressStyle::none}};
  sub.add_option("--threads", command.options.threads, "threads; default: the cores of this machine")
      ->type_name("T")
      ->check(CLI::Range(1, 1024).description(""))
      ->group("Run");
  sub.add_option("--report", command.report, "folder for report.json: all measures, counts and times")
      ->type_name("DIR")
      ->group("Run");
  sub.add_option("--progress", command.progress, "auto (a bar on a terminal, else lines), plain or none")
      ->transform(CLI::CheckedTransformer(styles).description(""))
      ->type_name("STYLE")
      ->group("Run");
  sub.add_flag("--quiet", command.quiet, "print nothing but errors")->group("Run");
  sub.add_flag("--force", command.force, "start even if the memory seems too small")->group("Run");
}

}  // namespace

void add_adapt_command(CLI::App& app, Action& action, const std::vector<std::string>& arguments) {
  CLI::App* sub = app.add_subcommand("adapt", "adapt a mesh to a metric");
  sub->footer(kFooter);
  auto command = std::make_shared<AdaptCommand>();
  command->arguments = arguments;
  command->options.threads = default_threads();
  add_files(*sub, *command);
  add_metric_source(*sub, command->metric);
  add_metric_construction(*sub, command->metric);
  add_background(*sub, *command);
  add_metric_processing(*sub, command->metric);
  add_field_options(*sub, command->fields, "IN", "Fields");
  add_geometry(*sub, *command);
  add_run(*sub, *command);
  sub->callback([command, &action] { action = [command] { return run(*command); }; });
}

}  // namespace weft::tools

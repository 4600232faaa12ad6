// `weft adapt`: the main job, from files to files.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "engine/mpi/mpi_transport.h"
#include "tools/report/published.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/jobs/adapt_job.h"
#include "tools/weft/jobs/distributed_job.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/report/graph_output.h"
#include "tools/weft/report/summary.h"

namespace weft::tools {
namespace {

constexpr const char* kFooter = R"(Examples:
  weft adapt wing.meshb --sol mach.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --metric wing.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --sol mach.solb --field flow.solb --transfer conservative -o fine.meshb
  weft adapt cube.meshb --metric-fn polar-2 -o layer.meshb --threads 2 --report report

Writes the mesh and, beside it, the metric at its vertices (fine.solb) and the transferred fields
(fine-fields.solb). A file is written completely or not at all.
--metric: a symmetric tensor (m11 m12 m22 m13 m23 m33) or a size at every vertex of the input, or of
--background. --sol: a solution whose interpolation error is minimised. The metric is scaled so that it has
the --complexity after limiting (--hmin, --hmax, --aspect) and gradation (--hgrad); expect about 2 vertices
and 12 tets per unit of complexity. Ctrl-C ends the run with a valid intermediate mesh and exit code 1.
Cases with published figures: cube-polar2-50000, cube-polar2-500000, delta-wing-500000.)";

struct AdaptCommand : AdaptRequest {
  SubdomainRequest subdomains;
  int threads = 0;  ///< 0: not given
  Verbosity verbosity;
};

/// Ranks share a machine: unless told otherwise each works with one thread.
int threads_of_rank() { return engine::under_mpirun() ? 1 : default_threads(); }

int run(AdaptCommand& command) {
  if (!command.metric.given())
    throw CLI::RequiredError(
        "no metric: give --metric FILE or --sol FILE (.solb or .sol) or --metric-fn NAME (such as polar-2)",
        CLI::ExitCodes::RequiredError);
  check_request(command.metric);
  command.progress = command.verbosity.style();
  command.options.threads = command.threads > 0 ? command.threads : threads_of_rank();
  if (in_subdomains(command.subdomains))
    return run_in_subdomains(command, command.subdomains, command.verbosity.quiet);
  if (!command.graph.empty()) throw CLI::RequiresError("--graph", "--subdomains");
  if (!command.trace.empty()) throw CLI::RequiresError("--trace", "--subdomains");
  const AdaptOutcome outcome = run_adapt(command);
  command.verbosity.print("{}", summary_text(outcome.run));
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
                 "keep boundary edges with a sharper angle; default 45 (also -ar)")
      ->type_name("DEG")
      ->check(CLI::Range(0.0, 180.0).description(""))
      ->group("Geometry");
  sub.add_option("--hausd", command.options.hausd,
                 "largest distance to the surface; default 0.1 % of the diagonal (also -hausd)")
      ->type_name("D")
      ->check(positive_number())
      ->group("Geometry");
}

void add_report_options(CLI::App& sub, AdaptCommand& command) {
  constexpr const char* kGroup = "Report";
  static const CLI::Validator graph_name(
      [](const std::string& name) {
        return graph_format(name) ? std::string()
                                  : "'" + name + "' must end in .json, .dot, .graphml or .svg";
      },
      "");
  sub.add_option("--report", command.report, "folder for report.html, report.json and profile.json")
      ->type_name("DIR")
      ->group(kGroup);
  std::vector<std::string> cases;
  for (const std::string_view name : report::published_cases()) cases.emplace_back(name);
  sub.add_option("--case", command.case_name, "compare with published figures of this case; see below")
      ->type_name("NAME")
      ->check(CLI::IsMember(cases).description(""))
      ->needs("--report")
      ->group(kGroup);
  sub.add_option("--graph", command.graph,
                 "executed task graph: .json, .dot, .graphml or .svg; the planned one beside it")
      ->type_name("FILE")
      ->check(graph_name)
      ->group(kGroup);
  sub.add_option("--trace", command.trace, "timeline for ui.perfetto.dev, .json")
      ->type_name("FILE")
      ->group(kGroup);
}

void add_run(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("--threads", command.threads, "threads per rank; default: all cores, under mpirun 1")
      ->type_name("T")
      ->check(CLI::Range(1, 1024).description(""))
      ->group("Run");
  add_report_options(sub, command);
  add_verbosity(sub, command.verbosity, "Run");
  sub.add_flag("--force", command.force, "run even if the memory seems insufficient")->group("Run");
}

void add_subdomains(CLI::App& sub, SubdomainRequest& request) {
  constexpr const char* kGroup = "Subdomains";
  static const std::map<std::string, bool> connections = {{"points", false}, {"faces", true}};
  sub.add_option("--subdomains", request.subdomains,
                 "number of subdomains; default 4 per thread under mpirun or with --partitioner")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 22).description(""))
      ->group(kGroup);
  sub.add_option("--partitioner", request.partitioner,
                 "graph (default), bisection, or slabs: pqr:PxQxR[:principal][:thin]")
      ->type_name("NAME")
      ->group(kGroup);
  static const std::map<std::string, bool> shares = {{"work", false}, {"tets", true}};
  sub.add_option("--equal", request.equal_tets,
                 "balance subdomains by predicted work (default) or by tets of the input")
      ->transform(CLI::CheckedTransformer(shares).description(""))
      ->type_name("WHAT")
      ->group(kGroup);
  sub.add_option("--layers", request.layers, "layers of tets migrated in the first shift; default 2")
      ->type_name("L")
      ->check(CLI::Range(0, 1000).description(""))
      ->group(kGroup);
  sub.add_option("--layers-by", request.by_faces, "layers grow across points (default) or faces")
      ->transform(CLI::CheckedTransformer(connections).description(""))
      ->type_name("KIND")
      ->group(kGroup);
  sub.add_option("--shifts", request.shifts,
                 "auto (default: until the whole interface is adapted, at most 12) or at most N")
      ->type_name("N")
      ->check(number_or_auto())
      ->group(kGroup);
  sub.add_option("--balancer", request.balancer, "stealing (default), diffusion or none")
      ->type_name("NAME")
      ->check(CLI::IsMember({"stealing", "diffusion", "none"}).description(""))
      ->group(kGroup);
  static const std::map<std::string, bool> frozen = {{"vertices", false}, {"tets", true}};
  sub.add_option("--freeze", request.freeze_tets,
                 "what is frozen at an interface: vertices (default) or, as in the paper, tets")
      ->transform(CLI::CheckedTransformer(frozen).description(""))
      ->type_name("WHAT")
      ->group(kGroup);
  sub.add_flag_callback(
         "--no-interface-refinement", [&request] { request.refine_interface = false; },
         "do not refine the interface before the interior is adapted")
      ->group(kGroup);
}

}  // namespace

void add_adapt_command(CLI::App& app, Action& action, const std::vector<std::string>& arguments) {
  CLI::App* sub = app.add_subcommand("adapt", "adapt a mesh to a metric");
  sub->footer(kFooter);
  auto command = std::make_shared<AdaptCommand>();
  command->arguments = arguments;
  add_files(*sub, *command);
  add_metric_source(*sub, command->metric);
  add_metric_construction(*sub, command->metric);
  add_background(*sub, *command);
  add_metric_processing(*sub, command->metric);
  add_field_options(*sub, command->fields, "IN", "Fields");
  add_geometry(*sub, *command);
  add_subdomains(*sub, command->subdomains);
  add_run(*sub, *command);
  sub->callback([command, &action] { action = [command] { return run(*command); }; });
}

}  // namespace weft::tools

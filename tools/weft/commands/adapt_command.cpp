// `weft adapt`: the main job, from files to files.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "tools/weft/commands/commands.h"
#include "tools/weft/options/field_options.h"
#include "tools/weft/options/limit_options.h"
#include "tools/weft/options/metric_options.h"
#include "tools/weft/options/model_options.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/interrupt.h"
#include "tools/weft/terminal/progress.h"
#include "weft/replay.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kAdaptFooter = R"(Examples:
  weft adapt wing.meshb --sol mach.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --metric wing.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --sol mach.solb --field flow.solb --transfer conservative -o fine.meshb
  weft adapt cube.meshb --metric-fn polar-2 -o layer.meshb --threads 2 --report report

Writes the mesh and, beside it, the metric at its vertices (fine.solb) and the transferred fields
(fine-fields.solb); a .pvtu has all of it in its pieces. A file is written completely or not at all.
--metric: a symmetric tensor (m11 m12 m22 m13 m23 m33) or a size at every vertex of the input, or of
--background. --sol: a solution whose interpolation error is minimised. The metric is scaled so that it has
the --complexity after limiting (--hmin, --hmax, --aspect) and gradation (--hgrad); expect about 2 vertices
and 12 tets per unit of complexity. A mesh that fits the metric already is left as it is, unless
--force is given. Ctrl-C, SIGTERM and SIGALRM end the run with a valid intermediate mesh and exit code 1.
Slabs: ALONG is harmonic=A,B (P slabs along what Laplace's equation makes between the triangles of reference
A and those of B) or wall=A,... (along the distance from triangles of these references).
Cases with published figures: cube-polar2-50000, cube-polar2-500000, delta-wing-500000.)";

struct AdaptCommand {
  Files files;
  Options options;
  FieldChoice fields;
  std::string shifts = "auto";
  SimulatedRanks simulation{.ranks = 0};  ///< 0 ranks: none are simulated
  std::string account;                    ///< what is printed in the end
  Verbosity verbosity;
};

/// Ranks share a machine: unless told otherwise each works with one thread.
int default_threads_of_rank() { return under_mpirun() ? 1 : default_threads(); }

/// What the run tells goes to the terminal, and signals end it in good order or ask how far it is.
FilesResult adapt_and_tell(AdaptCommand& command) {
  Progress progress(command.verbosity.style());
  const InterruptGuard interrupt;
  StateRequest state_request;
  RunOptions& run = command.options.run;
  const CheckpointRequest checkpoint_request;
  run.cancel = interrupt.flag();
  command.options.checkpoint.now = checkpoint_request.flag();
  run.state_on_signal = true;
  run.on_state = [&](const std::string& text) {
    progress.finish();
    fmt::print(stderr, "weft: {}", text);
  };
  run.on_failure = [](const std::string& why) { fmt::print(stderr, "error: {}\n", printable(why)); };
  if (command.verbosity.style() != ProgressStyle::none || !in_subdomains(command.options))
    run.progress = [&](const weft::Progress& now) {
      progress.show(now);
      if (!now.sentence && state_request.take()) progress.say(now.stage, now.done, now.tets);
      return true;
    };
  FilesResult result;
  if (command.simulation.ranks > 0) {
    const SimulatedFilesResult simulated = adapt_files_on(command.simulation, command.files, command.options);
    command.account = summary(simulated);
    result = simulated;
  } else {
    result = adapt_files(command.files, command.options);
    command.account = summary(result);
  }
  progress.finish();
  return result;
}

int run(AdaptCommand& command) {
  if (!command.options.metric.given()) throw CLI::RequiredError(kNoMetric, CLI::ExitCodes::RequiredError);
  if (command.options.run.threads == 0)
    command.options.run.threads = command.simulation.ranks > 0 ? 1 : default_threads_of_rank();
  if (command.shifts != "auto")
    command.options.distributed.shifts = static_cast<std::uint32_t>(std::stoul(command.shifts));
  command.files.fields = command.fields.files;
  command.options.transfer = command.fields.method;
  const FilesResult result = adapt_and_tell(command);
  if (!result.report_error.empty() && result.first)
    fmt::print(stderr, "weft: {}\n", printable(result.report_error));
  if (result.first) command.verbosity.print("{}", command.account);
  return result.goal_met() && result.report_error.empty() ? kDone : kGoalNotMet;
}

void add_files(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("IN", command.files.input, "the mesh to adapt")->type_name("FILE")->required();
  sub.add_option("-o,-x,--out", command.files.output, "the result (also -out)")
      ->type_name("FILE")
      ->check(volume_output_name())
      ->required();
}

void add_background(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("--background", command.files.background,
                 "the mesh that the metric belongs to; default: the input")
      ->type_name("FILE")
      ->group("Metric");
}

void add_geometry(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("--ridge-angle", command.options.geometry.ridge_angle,
                 "keep boundary edges with a sharper angle; default 45 (also -ar)")
      ->type_name("DEG")
      ->check(CLI::Range(0.0, 180.0).description(""))
      ->group("Geometry");
  add_model(sub, command.options.geometry);
  sub.add_option("--hausd", command.options.geometry.hausd,
                 "largest distance to surface; default at most 0.1 % of diagonal (also -hausd)")
      ->type_name("D")
      ->check(positive_number())
      ->group("Geometry");
  sub.add_flag_callback(
         "--no-surface-limit", [&command] { command.options.geometry.limit_metric = false; },
         "take the metric as it is where a curved boundary needs shorter edges")
      ->group("Geometry");
}

void add_operations(CLI::App& sub, AdaptCommand& command) {
  AllowedOperations& allowed = command.options.allowed;
  const auto ban = [&sub](const char* name, bool& member, const char* text) {
    sub.add_flag_callback(
           name, [&member] { member = false; }, text)
        ->group("Operations");
  };
  ban("--no-insert", allowed.insert, "neither split nor collapse edges: the vertices stay (also -noinsert)");
  ban("--no-swap", allowed.swap, "swap no edges and faces (also -noswap)");
  ban("--no-move", allowed.move, "move no vertices (also -nomove)");
}

void add_report_options(CLI::App& sub, AdaptCommand& command) {
  constexpr const char* kGroup = "Report";
  static const CLI::Validator graph_name(
      [](const std::string& name) {
        return !graph_format(name).empty() ? std::string()
                                           : "'" + name + "' must end in .json, .dot, .graphml or .svg";
      },
      "");
  sub.add_option("--report", command.files.report, "folder for report.html, report.json and profile.json")
      ->type_name("DIR")
      ->group(kGroup);
  CLI::Option* no_page = sub.add_flag_callback(
                                "--no-page", [&command] { command.files.page = false; },
                                "only report.json there: no timelines and task graph are kept")
                             ->needs("--report")
                             ->group(kGroup);
  sub.add_option("--case", command.files.case_name, "compare with published figures of this case; see below")
      ->type_name("NAME")
      ->check(CLI::IsMember(published_cases()).description(""))
      ->needs("--report")
      ->excludes(no_page)
      ->group(kGroup);
  sub.add_option("--graph", command.files.graph,
                 "executed task graph: .json, .dot, .graphml or .svg; the planned one beside it")
      ->type_name("FILE")
      ->check(graph_name)
      ->group(kGroup);
  sub.add_option("--trace", command.files.trace, "timeline for ui.perfetto.dev, .json")
      ->type_name("FILE")
      ->group(kGroup);
}

void add_run(CLI::App& sub, AdaptCommand& command) {
  sub.add_option("--threads", command.options.run.threads,
                 "threads per rank; default: all cores, under mpirun 1")
      ->type_name("T")
      ->check(CLI::Range(1, 1024).description(""))
      ->group("Run");
  add_report_options(sub, command);
  add_verbosity(sub, command.verbosity, "Run");
  add_limits(sub, command.options.run);
  sub.add_flag("--repair", command.options.run.repair,
               "mend an input that would be refused, and say what was done")
      ->group("Run");
  sub.add_flag_callback(
         "--no-verify", [&command] { command.options.run.verify = false; },
         "write the result without checking that it conforms")
      ->group("Run");
  sub.add_flag("--force", command.options.run.force,
               "run even if the memory seems insufficient, or the mesh fits already")
      ->group("Run");
}

void add_checkpoints(CLI::App& sub, AdaptCommand& command) {
  CheckpointOptions& checkpoint = command.options.checkpoint;
  constexpr const char* kGroup = "Run";
  sub.add_option("--checkpoint", checkpoint.folder,
                 "keep states to go on from in DIR while the run goes on; SIGUSR2: one now")
      ->type_name("DIR")
      ->group(kGroup);
  sub.add_option("--checkpoint-every", checkpoint.every,
                 "default 600, the first after 10, 20, 40 ...; 0: only at SIGUSR2")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber.description(""))
      ->needs("--checkpoint")
      ->group(kGroup);
  sub.add_option("--resume", checkpoint.resume,
                 "go on from the latest checkpoint in DIR, if any, on any ranks and threads")
      ->type_name("DIR")
      ->group(kGroup);
}

void add_subdomains(CLI::App& sub, AdaptCommand& command) {
  DistributedOptions& distributed = command.options.distributed;
  constexpr const char* kGroup = "Subdomains";
  using LayersBy = DistributedOptions::LayersBy;
  using Equal = DistributedOptions::Equal;
  using Freeze = DistributedOptions::Freeze;
  static const std::map<std::string, LayersBy> connections = {{"points", LayersBy::points},
                                                              {"faces", LayersBy::faces}};
  sub.add_option("--subdomains", distributed.subdomains,
                 "number of subdomains; default 4 per thread under mpirun or with --partitioner")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 22).description(""))
      ->group(kGroup);
  sub.add_option("--partitioner", distributed.partitioner,
                 "graph (default), bisection, or slabs: pqr:PxQxR[:ALONG][:principal][:fewer]")
      ->type_name("NAME")
      ->group(kGroup);
  static const std::map<std::string, Equal> shares = {{"work", Equal::work}, {"tets", Equal::tets}};
  sub.add_option("--equal", distributed.equal,
                 "balance subdomains by predicted work (default) or by tets of the input")
      ->transform(one_of(shares))
      ->type_name("WHAT")
      ->group(kGroup);
  sub.add_option("--layers", distributed.layers,
                 "layers of tets migrated in every shift; default 2 in the first, then 1")
      ->type_name("L")
      ->check(CLI::Range(0, 1000).description(""))
      ->group(kGroup);
  sub.add_option("--layers-by", distributed.layers_by, "layers grow across points (default) or faces")
      ->transform(one_of(connections))
      ->type_name("KIND")
      ->group(kGroup);
  sub.add_option("--shifts", command.shifts,
                 "auto (default: until all is adapted, at most 12) or N, beside coarse ones")
      ->type_name("N")
      ->check(number_or_auto())
      ->group(kGroup);
  sub.add_option("--balancer", distributed.balancer, "stealing (default), diffusion or none")
      ->type_name("NAME")
      ->check(CLI::IsMember({"stealing", "diffusion", "none"}).description(""))
      ->group(kGroup);
  static const std::map<std::string, Freeze> frozen = {{"vertices", Freeze::vertices},
                                                       {"tets", Freeze::tets}};
  sub.add_option("--freeze", distributed.freeze,
                 "what is frozen at an interface: vertices (default) or, as in the paper, tets")
      ->transform(one_of(frozen))
      ->type_name("WHAT")
      ->group(kGroup);
  sub.add_flag("--check", command.options.run.check,
               "check the invariants of all subdomains after every round; slow")
      ->group(kGroup);
  sub.add_flag_callback(
         "--no-interface-refinement", [&distributed] { distributed.interface_refinement = false; },
         "do not refine the interface before the interior is adapted")
      ->group(kGroup);
}

void add_simulation(CLI::App& sub, SimulatedRanks& simulation) {
  constexpr const char* kGroup = "Simulation";
  CLI::Option* ranks =
      sub.add_option("--simulate-ranks", simulation.ranks,
                     "run on N ranks that this thread simulates: the same result, virtual times")
          ->type_name("N")
          ->check(CLI::PositiveNumber.description(""))
          ->group(kGroup);
  sub.add_option("--simulate-network", simulation.network,
                 "between them: latency, bandwidth, topology as of weft replay; 2us,10GB/s")
      ->type_name("L,B[,T]")
      ->needs(ranks)
      ->group(kGroup);
  sub.add_option("--simulate-cores", simulation.cores,
                 "their threads share C cores, as ranks of one machine (default: one each)")
      ->type_name("C")
      ->check(CLI::PositiveNumber.description(""))
      ->needs(ranks)
      ->group(kGroup);
  sub.add_option("--simulate-slowdown", simulation.slowdown,
                 "their processors take so many times as long (default 1)")
      ->type_name("X")
      ->check(positive_number())
      ->needs(ranks)
      ->group(kGroup);
}

}  // namespace

void add_adapt_command(CLI::App& app, Action& action, const std::vector<std::string>& arguments) {
  CLI::App* sub = app.add_subcommand("adapt", "adapt a mesh to a metric");
  sub->footer(kAdaptFooter);
  auto command = std::make_shared<AdaptCommand>();
  command->files.arguments = arguments;
  add_files(*sub, *command);
  add_metric_source(*sub, command->options.metric);
  add_metric_construction(*sub, command->options.metric);
  add_background(*sub, *command);
  add_metric_processing(*sub, command->options.metric);
  add_field_options(*sub, command->fields, "IN", "Fields");
  add_geometry(*sub, *command);
  add_operations(*sub, *command);
  add_subdomains(*sub, *command);
  add_checkpoints(*sub, *command);
  add_run(*sub, *command);
  add_simulation(*sub, command->simulation);
  sub->callback([command, &action] { action = [command] { return run(*command); }; });
}

}  // namespace weft::tools

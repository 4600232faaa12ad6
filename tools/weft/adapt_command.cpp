// `weft adapt`: the main job, from files to files.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "meshing/adapt.h"
#include "meshing/error.h"
#include "meshing/io/mesh_file.h"
#include "tools/weft/adapt_run.h"
#include "tools/weft/commands.h"
#include "tools/weft/exit_codes.h"
#include "tools/weft/interrupt.h"
#include "tools/weft/metric_source.h"
#include "tools/weft/named_error.h"
#include "tools/weft/option_checks.h"
#include "tools/weft/progress.h"
#include "tools/weft/report_json.h"
#include "tools/weft/summary.h"
#include "tools/weft/text.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;
using meshing::LogMetricField;
using meshing::MeshData;

constexpr const char* kFooter = R"(Examples:
  weft adapt wing.meshb --sol mach.solb --complexity 500000 -o fine.meshb
  weft adapt wing.meshb --metric wing.solb --complexity 500000 -o fine.meshb
  weft adapt cube.meshb --metric-fn polar-2 -o layer.meshb --threads 2 --report report

Writes the mesh and, beside it, the metric at its vertices (fine.solb); both whole or not at all.
--metric holds a symmetric tensor (m11 m12 m22 m13 m23 m33) or a wanted size at every vertex of the
input, or of --background; --sol a solution whose interpolation error is to be least. The metric is scaled
so that it has the --complexity once it is limited (--hmin, --hmax, --aspect) and graded (--hgrad); expect
about 2 vertices and 12 tets a unit of complexity. Ctrl-C ends the run with the valid mesh reached so far
and exit code 1.)";

struct AdaptCommand {
  std::string input, output, background, report;
  MetricRequest metric;
  meshing::AdaptOptions options;
  ProgressStyle progress = ProgressStyle::automatic;
  bool quiet = false, force = false;
  std::vector<std::string> arguments;
};

/// Seconds since it was made or last asked.
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

bool same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return fs::equivalent(a, b, missing) && !missing;
}

/// One adaptation: its steps in order, each leaving its part of the account.
class AdaptJob {
 public:
  explicit AdaptJob(const AdaptCommand& command)
      : command_(command), progress_(command.quiet ? ProgressStyle::none : command.progress) {}

  int run() {
    // Also what TBB's loops outside adapt() may use; lets --threads exceed the cores.
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(command_.options.threads));
    describe();
    check_outputs();
    read();
    prepare_metric();
    check_size();
    measure_before();
    adapt();
    measure_after();
    write();
    return finish();
  }

 private:
  const MeshData& background() const { return background_ ? *background_ : input_; }

  void describe() {
    run_.arguments = command_.arguments;
    run_.input = command_.input;
    run_.metric = command_.metric.name();
    run_.outputs = output_paths(command_.output);
    run_.threads = command_.options.threads;
    if (!command_.report.empty()) run_.report_path = (fs::path(command_.report) / "report.json").string();
  }

  /// Hours of work must not end with "no such folder".
  void check_outputs() {
    for (const std::string& file : command_.metric.files())
      if (same_file(run_.outputs.solution, file) && !same_file(command_.output, command_.input))
        throw CLI::ValidationError(
            "--out", "its metric " + run_.outputs.solution + " would replace the input " + file);
    check_writable(run_.outputs.mesh);
    check_writable(run_.outputs.solution);
    if (command_.report.empty()) return;
    make_folder(command_.report);
    check_writable(run_.report_path);
  }

  void read() {
    progress_.update("reading", 0, 0);
    input_ = meshing::read_mesh(command_.input, &names_);
    if (!command_.background.empty() && !same_file(command_.background, command_.input))
      background_ = meshing::read_mesh(command_.background);
    if (input_.tets.empty()) throw InputError(command_.input, "", "has no tetrahedra");
    run_.input_counts = count(input_);
    run_.times.read = watch_.lap();
  }

  void prepare_metric() {
    progress_.update("metric", 0, run_.input_counts.tets);
    const std::string& owner = background_ ? command_.background : command_.input;
    MadeMetric made = make_metric(command_.metric, background(), owner);
    field_ = std::move(made.field);
    run_.warnings = std::move(made.warnings);
    run_.target_complexity = command_.metric.complexity > 0 ? command_.metric.complexity
                                                            : meshing::complexity(background(), field_);
    run_.times.metric = watch_.lap();
  }

  void check_size() {
    run_.predicted = predict_size(run_.target_complexity, run_.input_counts.vertices, run_.input_counts.tets);
    const std::string size =
        fmt::format("a complexity of {} means about {} vertices, {} tets and {} of memory",
                    grouped(run_.target_complexity), grouped(run_.predicted.vertices),
                    grouped(run_.predicted.tets), bytes_text(run_.predicted.bytes));
    if (!(run_.predicted.tets < kMaxTets))
      throw InputError(command_.input, "", size + ", more tets than one mesh can have: lower --complexity");
    const std::optional<double> room = available_memory();
    if (command_.force || !room || run_.predicted.bytes <= *room) return;
    throw InputError(command_.input, "",
                     size + ", but only " + bytes_text(*room) +
                         " are free here: lower --complexity, or try all the same with --force");
  }

  void measure_before() {
    watch_.lap();
    if (background_) return;
    progress_.update("measuring", 0, run_.input_counts.tets);
    run_.before = meshing::measure(input_, field_);
    run_.times.measure = watch_.lap();
  }

  void adapt() {
    meshing::AdaptOptions options = command_.options;
    options.interrupt = interrupt_.flag();
    options.progress = [this](const std::string& stage, double done, std::uint64_t tets) {
      progress_.update(stage, done, tets);
    };
    meshing::AdaptResult result = naming(command_.input, [&] {
      return meshing::adapt(input_, {&background(), &field_}, options);
    });
    mesh_ = std::move(result.mesh);
    log_metrics_ = std::move(result.log_metrics);
    run_.report = std::move(result.report);
    run_.warnings.insert(run_.warnings.end(), run_.report.warnings.begin(), run_.report.warnings.end());
    run_.output_counts = count(mesh_);
    run_.times.adapt = watch_.lap();
  }

  void measure_after() {
    progress_.update("measuring", 1, run_.output_counts.tets);
    run_.after = meshing::measure(mesh_, log_metrics_);
    run_.missed = missed_goals(run_.after, command_.metric.complexity, run_.report.interrupted);
    run_.times.measure += watch_.lap();
  }

  void write() {
    progress_.update("writing", 1, run_.output_counts.tets);
    write_mesh_with_solution(run_.outputs, mesh_, meshing::solution_from_metric(log_metrics_), names_);
    run_.times.write = watch_.lap();
  }

  /// Report and summary. The mesh is safe by now: a report that cannot be written costs the goal, not the
  /// mesh.
  int finish() {
    run_.times.total = total_.lap();
    run_.peak_memory = peak_memory_bytes();
    progress_.finish();
    int code = run_.missed.empty() ? kDone : kGoalNotMet;
    if (!run_.report_path.empty()) code = std::max(code, write_report());
    if (!command_.quiet) fmt::print("{}", summary_text(run_));
    return code;
  }

  int write_report() const {
    try {
      write_text(run_.report_path, json_of(run_).dump(1) + "\n");
      return kDone;
    } catch (const InputError& error) {
      fmt::print(stderr, "weft: {}\n", error.what());
      return kGoalNotMet;
    }
  }

  const AdaptCommand& command_;
  InterruptGuard interrupt_;
  Progress progress_;
  Stopwatch total_, watch_;
  AdaptRun run_;
  MeshData input_, mesh_;
  meshing::RefNames names_;             ///< of the input's references, which the result keeps
  std::optional<MeshData> background_;  ///< empty: the input
  LogMetricField field_, log_metrics_;
};

int run_adapt(const AdaptCommand& command) {
  if (!command.metric.given())
    throw CLI::RequiredError(
        "no metric: give --metric FILE or --sol FILE (.solb or .sol) or --metric-fn NAME (such as polar-2)",
        CLI::ExitCodes::RequiredError);
  check_request(command.metric);
  return AdaptJob(command).run();
}

int default_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

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
  add_geometry(*sub, *command);
  add_run(*sub, *command);
  sub->callback([command, &action] { action = [command] { return run_adapt(*command); }; });
}

}  // namespace weft::tools

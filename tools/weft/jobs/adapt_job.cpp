// Runs an adaptation: checks, reads, adapts, measures, writes.
#include "tools/weft/jobs/adapt_job.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "meshing/base/error.h"
#include "meshing/base/printable.h"
#include "meshing/io/mesh_file.h"
#include "tools/weft/jobs/named_error.h"
#include "tools/weft/jobs/run_work.h"
#include "tools/weft/jobs/stopwatch.h"
#include "tools/weft/report/report_json.h"
#include "tools/weft/report/run_record.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/interrupt.h"
#include "tools/weft/terminal/text.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;
using meshing::LogMetricField;
using meshing::MeshData;

bool same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return fs::equivalent(a, b, missing) && !missing;
}

/// One adaptation: its steps in order, each leaving its part of the account.
class AdaptJob {
 public:
  explicit AdaptJob(const AdaptRequest& request) : request_(request), progress_(request.progress) {}

  AdaptOutcome run() {
    // Also what TBB's loops outside adapt() may use; lets --threads exceed the cores.
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(request_.options.threads));
    run_ = begin_account(request_);
    check_outputs();
    read();
    prepare_metric();
    check_size();
    measure_before();
    adapt();
    measure_after();
    carry_fields();
    write();
    return finish();
  }

 private:
  const MeshData& background() const { return background_ ? *background_ : input_; }

  /// Hours of work must not end with "no such folder".
  void check_outputs() {
    const bool in_place = same_file(request_.output, request_.input);
    for (const std::vector<std::string>& inputs : {request_.metric.files(), request_.fields.files})
      for (const std::string& file : inputs)
        if (same_file(run_.outputs.solution, file) && !in_place)
          throw CLI::ValidationError(
              "--out", "its metric " + run_.outputs.solution + " would replace the input " + file);
    check_writable(run_.outputs.mesh);
    check_writable(run_.outputs.solution);
    if (request_.fields.given()) check_writable(run_.outputs.fields);
    if (request_.report.empty()) return;
    make_folder(request_.report);
    check_writable(run_.report_path);
  }

  void read() {
    progress_.update("reading", 0, 0);
    input_ = meshing::read_mesh(request_.input, &names_);
    if (!request_.background.empty() && !same_file(request_.background, request_.input))
      background_ = meshing::read_mesh(request_.background);
    if (input_.tets.empty()) throw InputError(request_.input, "", "has no tetrahedra");
    fields_ = read_fields(request_.fields, input_.points.size(), request_.input);
    run_.input_counts = count(input_);
    run_.times.read = watch_.lap();
  }

  void prepare_metric() {
    predict_work(request_.metric.complexity);
    progress_.update("metric", work_->at_metric(), run_.input_counts.tets);
    const std::string& owner = background_ ? request_.background : request_.input;
    MadeMetric made = make_metric(request_.metric, background(), owner);
    field_ = std::move(made.field);
    run_.warnings = std::move(made.warnings);
    run_.target_complexity = request_.metric.complexity > 0 ? request_.metric.complexity
                                                            : meshing::complexity(background(), field_);
    predict_work(run_.target_complexity);
    run_.times.metric = watch_.lap();
  }

  /// For the percentage; a complexity of 0 is not known yet, and taken to be the input's.
  void predict_work(double complexity) {
    constexpr double kTetsOfComplexity = 12;
    const double tets = static_cast<double>(run_.input_counts.tets);
    work_.emplace(tets, complexity > 0 ? kTetsOfComplexity * complexity : tets, request_.fields.given());
  }

  void check_size() {
    run_.predicted = predict_size(run_.target_complexity, run_.input_counts.vertices, run_.input_counts.tets);
    const std::string size =
        fmt::format("a complexity of {} means about {} vertices, {} tets and {} of memory",
                    grouped(run_.target_complexity), grouped(run_.predicted.vertices),
                    grouped(run_.predicted.tets), bytes_text(run_.predicted.bytes));
    if (!(run_.predicted.tets < kMaxTets))
      throw InputError(request_.input, "", size + ", more tets than one mesh can have: lower --complexity");
    const std::optional<double> room = available_memory();
    if (request_.force || !room || run_.predicted.bytes <= *room) return;
    throw InputError(request_.input, "",
                     size + ", but only " + bytes_text(*room) +
                         " are free here: lower --complexity, or try all the same with --force");
  }

  void measure_before() {
    watch_.lap();
    if (background_) return;
    progress_.update("measuring", work_->at_measures_before(), run_.input_counts.tets);
    run_.before = meshing::measure(input_, field_);
    run_.times.measure = watch_.lap();
  }

  void adapt() {
    meshing::AdaptOptions options = request_.options;
    options.interrupt = interrupt_.flag();
    options.progress = [this](const std::string& stage, double done, std::uint64_t tets) {
      const double share = work_->at_adaptation(done);
      progress_.update(stage, share, tets);
      if (state_request_.take()) progress_.say(stage, share, tets);
    };
    progress_.update("importing", work_->at_adaptation(0), run_.input_counts.tets);
    meshing::AdaptResult result = naming(request_.input, [&] {
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
    work_->adapted(static_cast<double>(run_.output_counts.tets));
    progress_.update("measuring", work_->at_adaptation(1), run_.output_counts.tets);
    run_.after = meshing::measure(mesh_, log_metrics_);
    run_.missed = missed_goals(run_.after, request_.metric.complexity, run_.report.interrupted);
    run_.times.measure += watch_.lap();
  }

  void carry_fields() {
    if (!request_.fields.given()) return;
    progress_.update("fields", work_->at_fields(), run_.output_counts.tets);
    watch_.lap();
    meshing::Transfer result = naming(
        request_.input, [&] { return meshing::transfer(input_, fields_, mesh_, request_.fields.method); });
    const std::vector<std::string> warnings = transfer_warnings(result, request_.input);
    run_.warnings.insert(run_.warnings.end(), warnings.begin(), warnings.end());
    run_.transfer = request_.fields.method;
    run_.field_accounts = std::move(result.accounts);
    fields_ = std::move(result.fields);
    run_.times.fields = watch_.lap();
  }

  void write() {
    progress_.update("writing", work_->at_writing(), run_.output_counts.tets);
    write_mesh_with_solution(run_.outputs, mesh_, meshing::solution_from_metric(log_metrics_), fields_,
                             names_);
    run_.times.write = watch_.lap();
  }

  /// The mesh is safe by now: a report that cannot be written costs the goal, not the mesh.
  AdaptOutcome finish() {
    run_.times.total = total_.lap();
    run_.peak_memory = peak_memory_bytes();
    progress_.finish();
    int code = run_.missed.empty() ? kDone : kGoalNotMet;
    if (!run_.report_path.empty()) code = std::max(code, write_report());
    return {code, std::move(run_)};
  }

  int write_report() const {
    try {
      write_text(run_.report_path, json_of(run_).dump(1) + "\n");
      if (request_.page) write_record(run_, record_of(mesh_, log_metrics_), request_.case_name);
      return kDone;
    } catch (const InputError& error) {
      fmt::print(stderr, "weft: {}\n", meshing::printable(error.what()));
      return kGoalNotMet;
    }
  }

  const AdaptRequest& request_;
  InterruptGuard interrupt_;
  StateRequest state_request_;
  Progress progress_;
  std::optional<RunWork> work_;  ///< once the input has been read
  Stopwatch total_, watch_;
  RunResult run_;
  MeshData input_, mesh_;
  meshing::RefNames names_;             ///< of the input's references, which the result keeps
  std::optional<MeshData> background_;  ///< empty: the input
  LogMetricField field_, log_metrics_;
  meshing::SolutionData fields_;  ///< carried along; of the input, then of the result
};

}  // namespace

RunResult begin_account(const AdaptRequest& request) {
  RunResult run;
  run.arguments = request.arguments;
  run.input = request.input;
  run.metric = request.metric.name();
  run.outputs = output_paths(request.output);
  run.threads = request.options.threads;
  run.asked_complexity = request.metric.complexity;
  if (!request.report.empty()) run.report_path = (fs::path(request.report) / "report.json").string();
  return run;
}

AdaptOutcome run_adapt(const AdaptRequest& request) { return AdaptJob(request).run(); }

}  // namespace weft::tools

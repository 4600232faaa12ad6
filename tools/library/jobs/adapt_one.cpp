#include "tools/library/jobs/adapt_one.h"

#include <fmt/format.h>

#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meshing/adapt/adapt.h"
#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/base/release.h"
#include "meshing/fields/coverage.h"
#include "meshing/fields/transfer.h"
#include "meshing/kernel/complete.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/metric/expectations.h"
#include "meshing/metric/fit.h"
#include "meshing/metric/measure_again.h"
#include "meshing/metric/measures.h"
#include "tools/common/naming.h"
#include "tools/common/text.h"
#include "tools/library/jobs/mesh_checkpoints.h"
#include "tools/library/jobs/resources/memory.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/result_check.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/jobs/run_work.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/jobs/sources/model_source.h"

namespace weft::tools {
namespace {

using meshing::InputError;

/// Options that say how to work in subdomains, of which there are none.
void warn_of_idle_options(const Options& options, std::vector<std::string>& warnings) {
  const Options plain;
  for (const char* name :
       {"equal", "layers", "layers-by", "shifts", "balancer", "freeze", "no-interface-refinement"})
    if (get_option(options, name) != get_option(plain, name))
      warnings.push_back(fmt::format("--{} has no effect without --subdomains", name));
}

/// The steps in order, each leaving its part of the result.
class OneMesh {
 public:
  OneMesh(const AdaptInput& input, const Options& options, Monitor& monitor)
      : input_(input), options_(options), monitor_(monitor) {
    result_.threads = number_of_threads(options.run.threads);
    result_.input_counts = count(input.mesh);
  }

  Result run() {
    if (input_.mesh.tets.empty()) throw InputError(input_.name, "", "has no tetrahedra");
    prepare_metric();
    check_size(input_.name, expected_complexity_, options_.run, result_.input_counts, result_.predicted);
    if (options_.run.measure) measure_before();
    if (!input_.fields.fields.empty()) monitor_.expect(seconds_to_carry(options_.transfer) / result_.threads);
    adapt();
    judge();
    if (!input_.fields.fields.empty())
      if_memory_lasts("the fields are not carried along", [this] { carry_fields(); });
    result_.missed =
        missed_goals(result_.after, options_.metric.complexity, result_.ended_by, result_.model.get());
    return std::move(result_);
  }

 private:
  const meshing::MeshData& background() const { return input_.background ? *input_.background : input_.mesh; }

  void prepare_metric() {
    model_ = model_of(options_.geometry, input_.mesh, input_.name);
    if (input_.model) *input_.model = model_;
    predict_work(options_.metric.complexity);
    monitor_.update("metric", work_->at_metric(), result_.input_counts.tets);
    const std::string& owner = input_.background ? input_.background_name : input_.name;
    const auto bound = input_.background ? std::nullopt : surface_bound(options_.geometry, input_.mesh);
    LogMetricMade made = make_log_metric(options_.metric, background(), owner, input_.metric, model_, bound,
                                         flag_for_metric(monitor_, options_.checkpoint));
    field_ = std::move(made.field);
    result_.surface_limit = made.surface_limit;
    result_.warnings = model_warnings(model_.get());
    warn_of_idle_options(options_, result_.warnings);
    result_.warnings.insert(result_.warnings.end(), made.warnings.begin(), made.warnings.end());
    if (input_.background)
      warn_of_uncovered(naming(owner, [&] { return meshing::uncovered(background(), input_.mesh); }),
                        result_.input_counts.vertices, result_.warnings);
    result_.complexity_asked = options_.metric.complexity > 0;
    result_.target_complexity =
        result_.complexity_asked ? options_.metric.complexity : meshing::complexity(background(), field_);
    expected_complexity_ = result_.complexity_asked ? made.complexity : result_.target_complexity;
    predict_work(result_.target_complexity);
    result_.times.metric = watch_.lap();
  }

  /// For the percentage.
  void predict_work(double complexity) {
    work_ = RunWork::to_complexity(static_cast<double>(result_.input_counts.tets), complexity,
                                   !input_.fields.fields.empty());
  }

  void measure_before() {
    watch_.lap();
    if (input_.background) return;
    monitor_.update("measuring", work_->at_measures_before(), result_.input_counts.tets);
    measured_.emplace(meshing::MetricMeshView{input_.mesh, field_});
    result_.before = measured_->measures();
    result_.times.measure = result_.times.measure_input = watch_.lap();
  }

  void adapt() {
    monitor_.update("importing", work_->at_adaptation(0), result_.input_counts.tets);
    meshing::AdaptOptions kernel;
    kernel.threads = result_.threads;
    kernel.complexity = result_.target_complexity;
    kernel.ridge_angle_degrees = options_.geometry.ridge_angle;
    kernel.hausd = options_.geometry.hausd;
    kernel.model = model_;
    kernel.allowed = options_.allowed;
    kernel.interrupt = &monitor_.flag();
    kernel.out_of_memory = [this] { monitor_.out_of_memory(); };
    kernel.progress = [this](const std::string& stage, double done, std::uint64_t tets) {
      monitor_.update(stage, work_->at_adaptation(done), tets);
    };
    prepare_checkpoints(kernel);
    if (!kernel.resume && leave_as_is()) return account_for_checkpoints();
    meshing::AdaptResult adapted = naming(input_.name, [&] {
      return meshing::adapt(input_.mesh, {&background(), &field_}, kernel);
    });
    account_for_checkpoints();
    result_.mesh = std::move(adapted.mesh);
    origins_ = std::move(adapted.origins);
    if (options_.run.verify) check_conforms(result_.mesh);
    result_.metric = Metric::from_logarithms(std::move(adapted.log_metrics));
    meshing::AdaptReport& report = adapted.report;
    result_.stages = std::move(report.stages);
    result_.operations = report.counts;
    result_.surface_deviation = report.surface_deviation;
    result_.hausd = report.hausd;
    result_.surface_demands = std::move(report.surface_demands);
    result_.model = report.model;
    result_.cancelled = report.interrupted;
    if (result_.cancelled) result_.ended_by = text_of(monitor_.reason());
    result_.warnings.insert(result_.warnings.end(), report.warnings.begin(), report.warnings.end());
    if (result_.model) warn_of_faults(*result_.model, result_.warnings);
    warn_of_deviation(result_.surface_deviation, result_.hausd, result_.warnings);
    result_.output_counts = count(result_.mesh);
    work_->adapted(static_cast<double>(result_.output_counts.tets));
    result_.times.adapt = watch_.lap();
  }

  /// Where the mesh fits its metric and is complete: it is the result then, and no other check would find
  /// more in it.
  bool leave_as_is() {
    if (input_.background || !may_stay(options_)) return false;
    naming(input_.name, [&] { meshing::check_arrays(input_.mesh); });
    if (field_.size() != input_.mesh.points.size()) return false;
    result_.left_as_is = meshing::fit_of(input_.mesh, field_);
    if (result_.left_as_is && !meshing::is_complete(input_.mesh)) result_.left_as_is.reset();
    if (!result_.left_as_is) return false;
    result_.mesh = input_.own ? std::move(*input_.own) : input_.mesh;
    result_.mesh.association = {};
    result_.metric = Metric::from_logarithms(std::move(field_));
    result_.hausd = options_.geometry.hausd > 0
                        ? options_.geometry.hausd
                        : meshing::kHausdOfDiagonal * norm(meshing::box_of(result_.mesh.points).size());
    result_.output_counts = count(result_.mesh);
    work_->adapted(static_cast<double>(result_.output_counts.tets));
    result_.times.adapt = watch_.lap();
    return true;
  }

  void prepare_checkpoints(meshing::AdaptOptions& kernel) {
    const CheckpointOptions& asked = options_.checkpoint;
    if (asked.folder.empty() && asked.resume.empty()) return;
    const std::uint64_t run = hash_of_run(input_.mesh, background(), field_, options_);
    if (!asked.resume.empty()) found_ = find_state(asked.resume, run, result_.warnings);
    if (found_) kernel.resume = &found_->state;
    if (!asked.resume.empty() && !found_) result_.warnings.push_back(begun_anew(asked.resume));
    if (asked.folder.empty()) return;
    checkpoints_.emplace(asked, run);
    kernel.states = &*checkpoints_;
  }

  void account_for_checkpoints() {
    if (!checkpoints_ && !found_) return;
    const auto stats = std::make_shared<CheckpointStats>();
    if (found_) stats->resumed = found_->folder;
    if (checkpoints_) checkpoints_->finish(*stats);
    if (!stats->failure.empty())
      result_.warnings.push_back("the latest checkpoint could not be written: " + stats->failure);
    result_.checkpoints = stats;
    found_.reset();
    checkpoints_.reset();
  }

  /// Who ends a run early wants what there is at once, and measures it if he wants to know: measures().
  void judge() {
    if (options_.run.measure && !result_.cancelled)
      if_memory_lasts("the result is not measured", [this] { measure_after(); });
    meshing::release(field_);
  }

  /// The mesh is there already: what fails now for lack of memory costs the goal, not the mesh.
  template <class F>
  void if_memory_lasts(const char* without, F f) {
    try {
      f();
    } catch (const std::bad_alloc&) {
      monitor_.out_of_memory();
      result_.cancelled = true;
      result_.ended_by = text_of(monitor_.reason());
      result_.warnings.push_back(std::string("not enough memory: ") + without);
    }
  }

  void measure_after() {
    monitor_.update("measuring", work_->at_adaptation(1), result_.output_counts.tets);
    result_.after = measures_of_result();
    result_.times.measure += watch_.lap();
  }

  /// Of a mesh in which little has changed, what has.
  Measures measures_of_result() const {
    if (result_.left_as_is && result_.before) return *result_.before;
    const meshing::MetricMeshView result{result_.mesh, result_.metric.logarithms()};
    std::optional<Measures> known;
    if (measured_ && !origins_.empty()) known = measured_->of_result({input_.mesh, field_}, result, origins_);
    return known ? *known : meshing::measure(result.mesh, result.log_metrics);
  }

  void carry_fields() {
    monitor_.update("fields", work_->at_fields(), result_.output_counts.tets);
    watch_.lap();
    Transfer carried = naming(input_.name, [&] {
      if (result_.left_as_is)
        return meshing::keep_fields(meshing::WholeDomain(result_.mesh), input_.fields, options_.transfer);
      return meshing::transfer(input_.mesh, input_.fields, result_.mesh, options_.transfer,
                               &monitor_.caller_waits());
    });
    account_for_transfer(carried, options_.transfer, input_.name, result_);
    result_.fields = std::move(carried.fields);
    result_.times.fields = watch_.lap();
  }

  const AdaptInput& input_;
  const Options& options_;
  Monitor& monitor_;
  Stopwatch watch_;
  std::optional<RunWork> work_;                  ///< from the metric on
  std::shared_ptr<const meshing::Model> model_;  ///< null: the surface is reconstructed
  meshing::LogMetricField field_;
  double expected_complexity_ = 0;                 ///< limits may leave less than what is asked for
  std::optional<meshing::MeasuredMesh> measured_;  ///< the input
  std::vector<std::uint32_t> origins_;             ///< AdaptResult::origins
  std::optional<FoundState> found_;
  std::optional<MeshCheckpoints> checkpoints_;
  Result result_;
};

}  // namespace

bool may_stay(const Options& options) {
  const GeometryOptions& geometry = options.geometry;
  return !options.run.force && geometry.model.empty() && (geometry.limit_metric || !(geometry.hausd > 0));
}

namespace {

std::string size_text(double complexity, const SizePrediction& predicted) {
  return fmt::format("a complexity of {} means about {} vertices, {} tets and {} of memory",
                     grouped(complexity), grouped(predicted.vertices), grouped(predicted.tets),
                     bytes_text(predicted.bytes));
}

}  // namespace

void check_size(const std::string& name, double complexity, const RunOptions& run, const MeshCounts& input,
                SizePrediction& predicted) {
  predicted = predict_size(complexity, input.vertices, input.tets);
  const std::string size = size_text(complexity, predicted);
  if (!(predicted.tets < kMaxTets))
    throw InputError(name, "", size + ", more tets than one mesh can have: lower --complexity");
  const std::optional<double> room = room_of_rank(1, run.max_memory);
  if (run.force || !room || predicted.bytes <= *room) return;
  const bool limited = run.max_memory > 0 && *room >= run.max_memory;
  throw InputError(
      name, "",
      size + ", but only " + bytes_text(*room) +
          (limited ? " are allowed: lower --complexity, raise --max-memory, or try all the same with --force"
                   : " are free here: lower --complexity, or try all the same with --force"));
}

void check_size_of_parts(const std::string& name, double complexity, const RunOptions& run,
                         const MeshCounts& input, std::uint32_t parts, int ranks, std::optional<double> room,
                         SizePrediction& predicted) {
  predicted = predict_size(complexity, input.vertices, input.tets);
  const std::string size = size_text(complexity, predicted);
  if (!(kSlotsOfSubdomain * predicted.tets / parts < kMaxTets))
    throw InputError(name, "", size + ", more tets than subdomains can have: more --subdomains");
  // Libraries and messages on their way, whatever the size; the rank that has the most. A wing to 500,000 on
  // 8 ranks: 254 MB, 234 to 289 measured; a cube to 60,000 on 2: 163 MB, 139 measured.
  constexpr double kOfEachRank = 60e6, kMostLoaded = 1.25;
  const double of_rank = predicted.bytes / ranks * (ranks > 1 ? kMostLoaded : 1) + kOfEachRank;
  if (run.force || !room || of_rank <= *room) return;
  throw InputError(
      name, "",
      fmt::format("{}, {} a rank, but only {} {}: lower --complexity, use more ranks, or try all "
                  "the same with --force",
                  size, bytes_text(of_rank), bytes_text(*room),
                  run.max_memory > 0 && *room >= run.max_memory ? "are allowed by --max-memory"
                                                                : "are free for it on one of them"));
}

Result adapt_one(const AdaptInput& input, const Options& options, Monitor& monitor) {
  return with_threads(number_of_threads(options.run.threads),
                      [&] { return OneMesh(input, options, monitor).run(); });
}

}  // namespace weft::tools

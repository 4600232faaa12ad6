// The steps that all ranks do together, whatever the mesh came from and wherever it goes.
#include "tools/library/jobs/distributed_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <sstream>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/freed_memory.h"
#include "meshing/base/release.h"
#include "meshing/metric/expectations.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/decompose/partitioner.h"
#include "partition/fields/transfer_in_parts.h"
#include "partition/fit/as_given.h"
#include "partition/output/measure_pieces.h"
#include "partition/output/sum_on_model.h"
#include "partition/verify/check_pieces.h"
#include "partition/verify/check_result.h"
#include "partition/verify/check_subdomains.h"
#include "tools/common/naming.h"
#include "tools/library/jobs/adapt_one.h"
#include "tools/library/jobs/distributed_stats.h"
#include "tools/library/jobs/resources/memory.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/report/run_progress_text.h"
#include "tools/library/version.h"

namespace weft::tools {

using graph::adaptation::ShiftRecord;

std::string partitioner_of(const DistributedOptions& options) {
  return options.partitioner.empty() ? "graph" : options.partitioner;
}

namespace {

/// "--NAME VALUE" of each option in which all ranks have to agree.
std::vector<std::string> options_of_all(const Options& options) {
  constexpr std::array<std::string_view, 4> kOfRank = {"threads", "force", "time-limit", "max-memory"};
  std::vector<std::string> texts;
  for (const NamedOption& option : named_options())
    if (std::ranges::find(kOfRank, option.name) == kOfRank.end())
      texts.push_back(fmt::format("--{} {}", option.name, get_option(options, option.name)));
  return texts;
}

}  // namespace

DistributedRun::DistributedRun(const Options& options, engine::Transport& transport, const Keep& keep,
                               Monitor::Clock::time_point begin)
    : options_(options),
      keep_(keep),
      threads_(options.run.threads > 0 ? options.run.threads : 1),
      shares_its_thread_(transport.virtual_time() != nullptr),
      monitor_(options.run, transport.size(), begin, transport.rank().value == 0) {
  graph::adaptation::register_adaptation(registry_);
  engine::RuntimeOptions engine;
  engine.threads = threads_;
  engine.balancer = engine::balancer_by_name(options.distributed.balancer);
  engine.local = &rank_;
  engine.trace.spans = keep.timelines;
  engine.notice = &monitor_.flag();
  engine.name_of = [this](engine::ObjectId id) { return name_of(id); };
  if (options.run.on_state) engine.on_state = options.run.on_state;
  engine.on_failure = [&options](const std::string& why) {
    const std::string& folder = options.checkpoint.folder;
    if (options.run.on_failure)
      options.run.on_failure(folder.empty() ? why
                                            : why + "; the same command with --resume " + folder +
                                                  " goes on from the last checkpoint there");
  };
  if (!options.checkpoint.folder.empty()) {
    checkpoints_.emplace(options.checkpoint.folder, options.checkpoint.every, options.checkpoint.now,
                         &monitor_.flag(), transport.rank().value, transport.size());
    engine.snapshots = &*checkpoints_;
  }
  runtime_.emplace(transport, registry_, engine);
  if (options.run.state_on_signal) show_state_.emplace(*runtime_);
  peers_.emplace(*runtime_);
  exchange_.emplace(*runtime_);
  const bool simulated = transport.virtual_time() != nullptr;  // all ranks have this process's memory
  if (keep.record && !simulated) memory_.emplace(transport.rank().value);
  agree_on_options();
  if (simulated) tells_ = monitor_.wanted();  // no message that a run without progress has not
  if (tells_) runtime_->set_bulletins(bulletins());
  if (!options.checkpoint.resume.empty()) find_checkpoints();
}

/// Ranks that were asked for different things would wait for each other, or worse. Whether progress is told
/// is rank 0's wish, which may be the only one that has a function for it.
void DistributedRun::agree_on_options() {
  constexpr std::string_view kEnd("\0", 1);  // names of files may have any other character
  const std::vector<std::string> mine = options_of_all(options_);
  const std::string first = partition::text_of_first(
      *peers_, fmt::format("{:d}{}{}", monitor_.wanted(), kEnd, fmt::join(mine, kEnd)));
  std::istringstream lines(first);
  std::string issue, line;
  std::getline(lines, line, kEnd[0]);
  tells_ = line == "1";
  for (const std::string& option : mine) {
    std::getline(lines, line, kEnd[0]);
    if (issue.empty() && option != line)
      issue = fmt::format("rank {}: options differ: {}; on rank 0: {}", runtime_->rank().value, option, line);
  }
  partition::agree(*peers_, issue);
}

/// Rank 0 looks, so that all go on from the same.
void DistributedRun::find_checkpoints() {
  std::vector<std::uint8_t> mine;
  if (first())
    for (const auto& place : graph::adaptation::find_checkpoints(options_.checkpoint.resume)) {
      const std::string text = std::to_string(place.number) + "\n" + place.manifest.text();
      mine.insert(mine.end(), text.c_str(), text.c_str() + text.size() + 1);
    }
  const std::vector<std::uint8_t> told = partition::allgather(*peers_, mine)[0];
  for (auto at = told.begin(); at != told.end();) {
    const auto end = std::find(at, told.end(), 0);
    add_checkpoint(std::string(at, end));
    at = end + 1;
  }
}

/// Those of the latest's run count.
void DistributedRun::add_checkpoint(const std::string& text) {
  const std::size_t end = text.find('\n');
  graph::adaptation::CheckpointPlace place;
  place.number = std::stoull(text.substr(0, end));
  place.folder = graph::adaptation::checkpoint_folder(options_.checkpoint.resume, place.number);
  place.manifest = graph::adaptation::CheckpointManifest::parse(text.substr(end + 1)).value();
  if (resume_.empty() && place.manifest.subdomains == 0)
    throw meshing::InputError(place.folder.string(), "",
                              "is a checkpoint of a run of one mesh, and this is one in subdomains");
  if (resume_.empty() || (place.manifest.run == resume_[0].manifest.run &&
                          place.manifest.home_ranks == resume_[0].manifest.home_ranks))
    resume_.push_back(std::move(place));
}

/// Twice a second, summed on the way to rank 0.
engine::Bulletins DistributedRun::bulletins() {
  using graph::adaptation::ProgressSums;
  return {std::chrono::milliseconds(500),
          [this] {
            const std::optional<ProgressSums> news = news_.take();
            return news ? engine::packed(*news) : engine::Payload{};
          },
          [](engine::Payload mine, engine::Payload more) {
            auto sums = engine::unpacked<ProgressSums>(std::move(mine));
            return engine::packed(sums += engine::unpacked<ProgressSums>(std::move(more)));
          },
          [this](engine::Payload all) {
            if (!estimator_) return;  // a run before or after that of the adaptation
            if (all.size() > 0) estimator_->hear(engine::unpacked<ProgressSums>(std::move(all)));
            const graph::adaptation::RunProgress now = estimator_->at(engine::now());
            monitor_.tell({text_of(now), true, now.share, now.left.tets});
          }};
}

std::string DistributedRun::name_of(engine::ObjectId id) const {
  const auto subdomain = subdomain_of(rank_.plan, runtime_->ranks(), id);
  return subdomain ? fmt::format("subdomain {}", subdomain->value)
                   : fmt::format("mailbox of rank {}", id.home.value);
}

void DistributedRun::warn_of_other_subdomains(Report& report) const {
  const std::uint32_t asked = options_.distributed.subdomains;
  if (resume_.empty() || asked == 0 || asked == resume_[0].manifest.subdomains) return;
  report.warnings.push_back(fmt::format("--subdomains {} has no effect: the run in {} has {}", asked,
                                        options_.checkpoint.resume, resume_[0].manifest.subdomains));
}

/// All ranks: they may have different numbers of threads.
std::uint32_t DistributedRun::number_of_subdomains() {
  constexpr std::uint32_t kForEachThread = 4;  // so that there is something to balance with
  if (!resume_.empty()) return resume_[0].manifest.subdomains;
  if (options_.distributed.subdomains > 0) return options_.distributed.subdomains;
  const std::array<std::uint32_t, 3> slabs =
      partition::parse_partitioner(partitioner_of(options_.distributed)).slabs;
  if (slabs[0] > 0) return slabs[0] * slabs[1] * slabs[2];
  return kForEachThread * partition::sum(*peers_, static_cast<std::uint32_t>(threads_));
}

/// With what a plan does not tell.
std::uint64_t DistributedRun::hash_of_program() const {
  const GeometryOptions& geometry = options_.geometry;
  const std::string text =
      fmt::format("{} {} {} {}", kVersion, geometry.ridge_angle, geometry.model_scale, geometry.model);
  return graph::adaptation::hash_bytes(text.data(), text.size(), registry_.fingerprint());
}

graph::adaptation::DistributedOptions DistributedRun::method_options(double target_complexity) {
  const DistributedOptions& asked = options_.distributed;
  graph::adaptation::DistributedOptions method;
  method.decomposition.num_subdomains = number_of_subdomains();
  method.decomposition.partitioner =
      partition::parse_partitioner(partitioner_of(asked), method.decomposition.num_subdomains);
  method.decomposition.partitioner.runs_suffice = asked.partitioner.empty();
  method.decomposition.equal_tets = asked.equal == DistributedOptions::Equal::tets;
  method.decomposition.ridge_angle_degrees = options_.geometry.ridge_angle;
  method.decomposition.model = model_;
  method.decomposition.target_complexity = target_complexity;
  method.shift.layers = asked.layers.value_or(method.shift.layers);
  method.shift.by_faces = asked.layers_by == DistributedOptions::LayersBy::faces;
  method.shift.fewer_later = !asked.layers;
  if (asked.shifts) method.most_shifts = *asked.shifts;
  method.refine_interface = asked.interface_refinement;
  method.tets_at_frozen_stay = asked.freeze == DistributedOptions::Freeze::tets;
  method.allowed = options_.allowed;
  method.hausd = options_.geometry.hausd;
  method.check = options_.run.check;
  method.threads = threads_;
  method.interrupt = &monitor_.flag();
  method.out_of_memory = [this] { monitor_.out_of_memory(); };
  if (checkpoints_) method.checkpoints = &*checkpoints_;
  method.resume = resume_;
  method.program = hash_of_program();
  if (tells_) method.news = &news_;
  method.on_start = [this, subdomains = method.decomposition.num_subdomains, shifts = method.most_shifts] {
    before_loop_ = runtime_->summary();
    if (first()) estimator_.emplace(subdomains, shifts, engine::now());
  };
  method.on_end = [this] { after_loop_ = runtime_->summary(); };
  return method;
}

/// All ranks come to the same conclusion.
void DistributedRun::check_room(const std::string& name, Report& report) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const double mine = room_of_rank(runtime_->ranks(), options_.run.max_memory).value_or(kUnknown);
  const double least = partition::min(*peers_, std::vector{mine})[0];
  check_size_of_parts(name, rank_.plan.expected_complexity, options_.run, report.input_counts,
                      rank_.plan.subdomains, runtime_->ranks(),
                      least < kUnknown ? std::optional(least) : std::nullopt, report.predicted);
}

/// Of one rank the exception is what it is; of several it says which rank has it.
std::shared_ptr<const meshing::Model> DistributedRun::read_model(const meshing::MeshData& mesh,
                                                                 const std::string& name) {
  if (options_.geometry.model.empty()) return nullptr;
  meshing::MeshData carrier;
  if (options_.geometry.model == "carried")
    carrier.association.model = partition::allgather(*peers_, mesh.association.model)[0];
  partition::agree_on(*peers_, [&] {
    try {
      model_ = model_of(options_.geometry, carrier, name);
    } catch (const meshing::InputError& error) {
      if (runtime_->ranks() == 1) throw;
      throw std::runtime_error(fmt::format("rank {}: {}", runtime_->rank().value, error.what()));
    }
  });
  return model_;
}

bool DistributedRun::leave_as_is(const partition::MeshSlice& slice,
                                 const graph::adaptation::DistributedOptions& method, Report& report) {
  const bool may_not = method.background || !method.resume.empty() || !may_stay(options_);
  if (partition::max(*peers_, may_not ? 1 : 0) != 0) return false;  // ranks may differ in --force
  Stopwatch watch;
  std::optional<partition::AsGiven> given =
      partition::as_given(*peers_, slice, method.decomposition.target_complexity);
  if (!given) return false;
  report.left_as_is = given->fit;
  report.predicted = predict_size(given->complexity, report.input_counts.vertices, report.input_counts.tets);
  rank_.plan.subdomains = method.decomposition.num_subdomains;
  rank_.plan.first_object = graph::adaptation::EnginePeers::kObjects + 1;
  rank_.plan.home_ranks = peers_->ranks();
  rank_.plan.shift = method.shift;
  rank_.plan.expected_complexity = given->complexity;
  rank_.plan.hausd = method.hausd > 0 ? method.hausd : meshing::kHausdOfDiagonal * norm(given->box.size());
  result_.was_interface.emplace_back(given->piece.mesh.points.size(), 0);
  result_.pieces.push_back(std::move(given->piece));
  if (method.check) {
    partition::throw_if_violated(partition::check_pieces(*peers_, result_.pieces), "in the result");
    result_.checks = 1;
  }
  before_loop_ = after_loop_ = runtime_->summary();
  result_.adaptation_seconds = watch.lap();
  return true;
}

void DistributedRun::adapt(partition::MeshSlice&& slice, double target_complexity, const std::string& name,
                           Report& report, partition::MeshSlice* background,
                           const std::function<void(const partition::MeshSlice&)>& measure_input) {
  report.threads = threads_;
  if (first()) {
    const std::vector<std::string> of_model = model_warnings(model_.get());
    report.warnings.insert(report.warnings.end(), of_model.begin(), of_model.end());
    const std::string& folder = options_.checkpoint.resume;
    if (!folder.empty() && resume_.empty()) report.warnings.push_back(begun_anew(folder));
    warn_of_other_subdomains(report);
  }
  monitor_.update("decomposition", 0, report.input_counts.tets);
  naming(name, [&] {
    graph::adaptation::DistributedOptions method = method_options(target_complexity);
    method.background = background;
    method.on_plan = [&] { check_room("", report); };
    on_threads([&] {
      if (leave_as_is(slice, method, report)) {
        slice = {};
      } else {
        if (measure_input) measure_input(slice);
        result_ = adapt_distributed(*runtime_, *peers_, rank_, std::move(slice), method);
      }
    });
  });
  give_back_freed_memory();  // of messages and subdomains
  estimator_.reset();
  if (options_.run.verify && !report.left_as_is)
    on_threads([&] { partition::check_result(*peers_, result_.pieces); });
  report.warnings.insert(report.warnings.end(), result_.warnings.begin(), result_.warnings.end());
  warn_of_uncovered(result_.uncovered, report.input_counts.vertices, report.warnings);
  report.complexity_asked = options_.metric.complexity > 0;
  report.target_complexity =
      report.complexity_asked ? options_.metric.complexity : rank_.plan.expected_complexity;
  report.times.decompose = result_.decomposition_seconds;
  report.times.adapt = result_.adaptation_seconds;
  // One rank's reason ends them all.
  const auto reason =
      static_cast<EndReason>(partition::max(*peers_, static_cast<std::uint8_t>(monitor_.reason())));
  report.cancelled = reason != EndReason::none;
  report.ended_by = text_of(reason);
  report.surface_deviation = partition::max(*peers_, result_.surface_deviation);
  report.hausd = rank_.plan.hausd;
  warn_of_deviation(report.surface_deviation, report.hausd, report.warnings);
  if (model_) {
    ModelAccount account = meshing::account_of(*model_, partition::sum_on_model(*peers_, result_.on_model));
    account.input = result_.input_on_model;
    warn_of_faults(account, report.warnings);
    report.model = std::make_shared<const ModelAccount>(std::move(account));
  }
  report.missed = missed_goals(report.after, options_.metric.complexity, report.ended_by, report.model.get());
  gather_statistics(report);
}

/// Rank 0 hears the sums; of each rank and each run of a node as far as that is kept.
void DistributedRun::gather_statistics(Report& report) {
  graph::dataflow::ExecutionLog log = graph::adaptation::execution_log(*runtime_);
  const RankStats mine = seconds_of_rank(*peers_, log, runtime_->summary());
  if (keep_.record) log = gather_log(*exchange_, std::move(log));
  const engine::TimePoint clock_offset = runtime_->clock_offset();
  engine::RunSummary sums =
      keep_.by_rank ? engine::merge(runtime_->gather_summaries()) : runtime_->gather_sums();
  if (keep_.record) gather_runs(*exchange_, log, clock_offset, rank_.plan, record_);
  if (keep_.plan) gather_plan(*exchange_, std::move(result_.planned), rank_.plan, record_);
  std::vector<ShiftRecord> shifts;
  for (const auto& list : result_.shifts) shifts.insert(shifts.end(), list.begin(), list.end());
  report.operations += partition::reduce(*peers_, std::vector{result_.counts}, [](auto a, const auto& b) {
    a += b;
    return a;
  })[0];
  stats_ = std::make_shared<DistributedStats>(account_for(*peers_, mine, shifts, keep_.by_rank));
  account_for_checkpoints(sums, report);
  add_engine(std::move(sums), *stats_);
  stats_->subdomains = rank_.plan.subdomains;
  stats_->partitioner = result_.cut_by_runs ? "runs" : partitioner_of(options_.distributed);
  stats_->layers = rank_.plan.shift.layers;
  stats_->checks = result_.checks;
  stats_->coarse_shifts = static_cast<std::uint32_t>(rank_.plan.phases.back().first_round);
  stats_->divided_from = static_cast<std::uint32_t>(rank_.plan.seeds.size());
  stats_->division = rank_.plan.division.value_or(0);
  stats_->decomposition_seconds = result_.decomposition_seconds;
  stats_->adaptation_seconds = result_.adaptation_seconds;
  stats_->exchanged_before = sum_exchanges(*peers_, engine::exchanged_between({}, before_loop_));
  stats_->exchanged_in_loop = sum_exchanges(*peers_, engine::exchanged_between(before_loop_, after_loop_));
  report.distributed = stats_;
}

void DistributedRun::account_for_checkpoints(const engine::RunSummary& sums, Report& report) {
  CheckpointStats& stats = stats_->checkpoints;
  stats.resumed = result_.resumed.string();
  if (!checkpoints_) return;
  const graph::adaptation::CheckpointsWritten written = checkpoints_->written();
  stats.written = written.written;
  stats.bytes = static_cast<double>(written.bytes);
  stats.failure = written.failure;
  const auto seconds = sums.counters.find("snapshot_seconds");
  if (seconds != sums.counters.end()) stats.seconds = seconds->second.sum;
  if (first() && !stats.failure.empty())
    report.warnings.push_back("the latest checkpoint could not be written: " + stats.failure);
}

void DistributedRun::account_for_exchanges() {
  stats_->exchanged_after =
      sum_exchanges(*peers_, engine::exchanged_between(after_loop_, runtime_->summary()));
}

const partition::Numbering& DistributedRun::numbering() {
  if (!numbering_) numbering_ = on_threads([&] { return partition::number_pieces(*peers_, result_.pieces); });
  return *numbering_;
}

void DistributedRun::measure(Report& report) {
  monitor_.update("measuring", 1, 0);
  const partition::WholeAndPart measures = on_threads([&] {
    if (keep_.view) gather_view(*exchange_, *peers_, result_.pieces, model_.get(), record_);
    return partition::measure_pieces(*peers_, result_.pieces, result_.was_interface,
                                     numbering_ ? &*numbering_ : nullptr);
  });
  report.after = measures.whole;
  if (report.left_as_is) report.before = report.after;
  stats_->former_interface = measures.part;
  report.output_counts = {report.after->num_vertices, report.after->num_tets, report.after->num_triangles, 0};
  report.missed = missed_goals(report.after, options_.metric.complexity, report.ended_by, report.model.get());
}

void DistributedRun::give_back_freed_memory() const {
  if (!shares_its_thread_) meshing::give_back_freed_memory();
}

meshing::Transfer DistributedRun::carry(partition::MeshSlice&& from, const meshing::SolutionData& fields,
                                        partition::MeshSlice& to, bool same_mesh) {
  if (same_mesh)
    return partition::keep_fields_in_parts(*peers_, from, fields, to.points.size(), options_.transfer);
  const auto slices_are_read = [&] {
    from = {};
    meshing::release(to.tets);
    meshing::release(to.tet_refs);
    give_back_freed_memory();
  };
  return partition::transfer_in_parts(*peers_, from, fields, to, options_.transfer, &monitor_.caller_waits(),
                                      slices_are_read);
}

void DistributedRun::count(Report& report) {
  const auto& totals = numbering().totals;
  report.output_counts = {totals.points, totals.tets, totals.triangles, totals.edges};
}

void DistributedRun::gather_machines() {
  if (memory_) tools::gather_machines(*exchange_, memory_->stop(), record_);
}

}  // namespace weft::tools

// The steps of a run in subdomains, done by all ranks together.
#include "tools/weft/jobs/distributed_job.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/mpi/mpi_transport.h"
#include "engine/run/launch.h"
#include "engine/run/show_state_on_signal.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "meshing/base/error.h"
#include "meshing/base/printable.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/decompose/partitioner.h"
#include "partition/output/measure_pieces.h"
#include "partition/output/merge_pieces.h"
#include "partition/output/output.h"
#include "partition/output/piece_files.h"
#include "partition/verify/check_subdomains.h"
#include "tools/weft/jobs/gather_pieces.h"
#include "tools/weft/jobs/named_error.h"
#include "tools/weft/jobs/slice_source.h"
#include "tools/weft/jobs/stopwatch.h"
#include "tools/weft/jobs/subdomain_account.h"
#include "tools/weft/report/report_json.h"
#include "tools/weft/report/run_record.h"
#include "tools/weft/report/summary.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/interrupt.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using graph::adaptation::DistributedResult;
using graph::adaptation::EnginePeers;
using graph::adaptation::RankData;

std::string partitioner_of(const SubdomainRequest& request) {
  return request.partitioner.empty() ? "graph" : request.partitioner;
}

/// One run on one rank. All ranks do the same steps; only rank 0 says anything.
class DistributedJob {
 public:
  DistributedJob(const AdaptRequest& request, const SubdomainRequest& subdomains,
                 engine::Transport& transport)
      : request_(request), subdomains_(subdomains), progress_(style_on(transport, request)) {
    graph::adaptation::register_adaptation(registry_);
    engine::RuntimeOptions options;
    options.threads = request.options.threads;
    options.balancer = engine::balancer_by_name(subdomains.balancer);
    options.local = &rank_;
    options.trace.spans = keeps_record();
    if (request.progress != ProgressStyle::none) options.bulletins = bulletins();
    options.name_of = [this](engine::ObjectId id) { return name_of(id); };
    options.on_state = [this](const std::string& text) {
      progress_.finish();
      engine::print_state("weft: " + text);
    };
    runtime_.emplace(transport, registry_, options);
    show_state_.emplace(*runtime_);
    peers_.emplace(*runtime_);
    if (keeps_record()) memory_.emplace(transport.rank().value);
  }

  /// Exit code; the account is complete on rank 0.
  int run() {
    run_ = begin_account(request_);
    partition::agree_on(*peers_, [&] {
      if (first()) check_outputs();
    });
    SliceInput input = read();
    adapt(std::move(input));
    measure();
    write();
    return finish();
  }

  const RunResult& account() const { return run_; }
  bool first() const { return runtime_->rank().value == 0; }

 private:
  static ProgressStyle style_on(const engine::Transport& transport, const AdaptRequest& request) {
    return transport.rank().value == 0 ? request.progress : ProgressStyle::none;
  }

  /// The subdomains' news go to rank 0 twice a second.
  engine::Bulletins bulletins() {
    return {std::chrono::milliseconds(500),
            [this] {
              const auto news = news_.take();
              return news.empty() ? engine::Payload{} : engine::packed(news);
            },
            [this](engine::Rank, engine::Payload payload) {
              if (!table_) return;  // a run before or after that of the adaptation
              if (payload.size() > 0)
                table_->hear(
                    engine::unpacked<std::vector<graph::adaptation::SubdomainProgress>>(std::move(payload)));
              progress_.update(table_->at(engine::now()));
            }};
  }

  std::string name_of(engine::ObjectId id) const {
    const auto subdomain = subdomain_of(rank_.plan, runtime_->ranks(), id);
    return subdomain ? fmt::format("subdomain {}", subdomain->value)
                     : fmt::format("mailbox of rank {}", id.home.value);
  }

  void check_outputs() {
    check_writable(run_.outputs.mesh);
    if (fs::path(run_.outputs.mesh).extension() != ".pvtu") check_writable(run_.outputs.solution);
    for (const std::string& path : {request_.graph, request_.trace})
      if (!path.empty()) check_writable(path);
    if (!request_.graph.empty()) check_writable(planned_path(request_.graph));
    if (request_.report.empty()) return;
    make_folder(request_.report);
    check_writable(run_.report_path);
  }

  SliceInput read() {
    progress_.update("reading", 0, 0);
    SliceInput input = read_slice(*peers_, request_);
    run_.warnings = input.warnings;
    run_.input_counts = {input.slice.num_points, input.slice.num_tets, input.slice.boundary.triangles.size(),
                         input.slice.boundary.edges.size()};
    run_.times.read = watch_.lap();
    if (input.whole && first()) run_.before = meshing::measure(*input.whole, input.whole_metric);
    partition::agree_on(*peers_, [&] {
      if (!request_.fields.given() || !first()) return;
      fields_ = read_fields(request_.fields, input.whole->points.size(), request_.input);
      whole_ = std::move(*input.whole);
    });
    input.whole.reset();
    run_.times.measure = watch_.lap();
    return input;
  }

  std::uint32_t number_of_subdomains() const {
    constexpr std::uint32_t kForEachThread = 4;  // so that there is something to balance with
    if (subdomains_.subdomains > 0) return subdomains_.subdomains;
    const std::array<std::uint32_t, 3> slabs =
        partition::parse_partitioner(partitioner_of(subdomains_)).slabs;
    if (slabs[0] > 0) return slabs[0] * slabs[1] * slabs[2];
    return kForEachThread * static_cast<std::uint32_t>(runtime_->ranks() * request_.options.threads);
  }

  void adapt(SliceInput input) {
    graph::adaptation::DistributedOptions options;
    options.decomposition.num_subdomains = number_of_subdomains();
    options.decomposition.partitioner =
        partition::parse_partitioner(partitioner_of(subdomains_), options.decomposition.num_subdomains);
    options.decomposition.equal_tets = subdomains_.equal_tets;
    options.decomposition.ridge_angle_degrees = request_.options.ridge_angle_degrees;
    options.decomposition.target_complexity = input.target_complexity;
    options.shift = {subdomains_.layers, subdomains_.by_faces};
    if (subdomains_.shifts != "auto")
      options.most_shifts = static_cast<std::uint32_t>(std::stoul(subdomains_.shifts));
    options.refine_interface = subdomains_.refine_interface;
    options.tets_at_frozen_stay = subdomains_.freeze_tets;
    options.hausd = request_.options.hausd;
    options.check = subdomains_.check;
    options.threads = request_.options.threads;
    options.interrupt = interrupt_.flag();
    if (request_.progress != ProgressStyle::none) options.news = &news_;
    options.on_start = [&] {
      if (first()) table_.emplace(options.decomposition.num_subdomains, options.most_shifts, engine::now());
    };
    progress_.update("decomposition", 0, run_.input_counts.tets);
    result_ = naming(request_.input, [&] {
      return adapt_distributed(*runtime_, *peers_, rank_, std::move(input.slice), options);
    });
    table_.reset();
    run_.warnings.insert(run_.warnings.end(), result_.warnings.begin(), result_.warnings.end());
    run_.target_complexity = rank_.plan.expected_complexity;
    run_.times.metric = result_.decomposition_seconds;
    run_.times.adapt = result_.adaptation_seconds;
    run_.report.interrupted = interrupt_.raised();
    watch_.lap();
    gather_statistics(options);
  }

  /// Rank 0 hears of all.
  void gather_statistics(const graph::adaptation::DistributedOptions& options) {
    dataflow_exchange_.emplace(*runtime_);
    graph::dataflow::ExecutionLog log =
        gather_log(*dataflow_exchange_, graph::adaptation::execution_log(*runtime_));
    const engine::TimePoint clock_offset = keeps_record() ? runtime_->timeline().clock_offset : 0;
    std::vector<engine::RankSummary> summaries = runtime_->gather_summaries();
    if (keeps_record()) gather_runs(*dataflow_exchange_, log, clock_offset, rank_.plan, record_);
    if (!request_.graph.empty())
      gather_plan(*dataflow_exchange_, std::move(result_.planned), rank_.plan, record_);
    std::vector<graph::adaptation::ShiftRecord> mine;
    for (const auto& list : result_.shifts) mine.insert(mine.end(), list.begin(), list.end());
    std::vector<graph::adaptation::ShiftRecord> all;
    for (const auto& part : partition::allgather(*peers_, mine))
      all.insert(all.end(), part.begin(), part.end());
    for (const auto& counts :
         partition::allgather(*peers_, std::vector<meshing::OperationCounts>{result_.counts}))
      run_.report.counts += counts[0];
    DistributedStats account = account_for(log, std::move(summaries), all);
    account.subdomains = options.decomposition.num_subdomains;
    account.ranks = runtime_->ranks();
    account.partitioner = partitioner_of(subdomains_);
    account.layers = options.shift.layers;
    account.checks = result_.checks;
    account.coarse_shifts = static_cast<std::uint32_t>(rank_.plan.phases.back().first_round);
    account.decomposition_seconds = result_.decomposition_seconds;
    account.adaptation_seconds = result_.adaptation_seconds;
    account_ = std::make_shared<DistributedStats>(std::move(account));
    run_.subdomains = account_;
  }

  bool keeps_record() const {
    return !(request_.report.empty() && request_.graph.empty() && request_.trace.empty());
  }

  void measure() {
    progress_.update("measuring", 1, 0);
    if (!request_.report.empty()) gather_view(*dataflow_exchange_, *peers_, result_.pieces, record_);
    run_.after = partition::measure_pieces(*peers_, result_.pieces);
    account_->former_interface = partition::measure_pieces(*peers_, result_.pieces, result_.was_interface);
    run_.output_counts = {run_.after.num_vertices, run_.after.num_tets, run_.after.num_triangles, 0};
    run_.missed = missed_goals(run_.after, request_.metric.complexity, run_.report.interrupted);
    run_.times.measure += watch_.lap();
  }

  void write() {
    progress_.update("writing", 1, run_.output_counts.tets);
    const fs::path mesh = run_.outputs.mesh;
    if (mesh.extension() == ".pvtu" && !request_.fields.given()) {
      partition::write_pieces_as_vtu(*peers_, result_.pieces, mesh);
      run_.outputs.solution = run_.outputs.mesh;
    } else if (mesh.extension() == ".meshb" && !request_.fields.given()) {
      partition::write_pieces(*peers_, result_.pieces, mesh, run_.outputs.solution);
    } else {
      write_by_first();
    }
    run_.times.write = watch_.lap();
  }

  /// Formats that one program writes, and fields: rank 0 gets the whole mesh.
  void write_by_first() {
    const std::vector<partition::MeshPiece> pieces =
        gather_pieces(*dataflow_exchange_, std::move(result_.pieces));
    partition::agree_on(*peers_, [&] {
      if (!first()) return;
      const partition::MergedMesh merged = partition::merge_pieces(pieces);
      if (request_.fields.given()) carry_fields(merged.mesh);
      write_mesh_with_solution(run_.outputs, merged.mesh, meshing::solution_from_metric(merged.log_metrics),
                               fields_);
    });
  }

  void carry_fields(const meshing::MeshData& mesh) {
    meshing::Transfer result = meshing::transfer(whole_, fields_, mesh, request_.fields.method);
    const std::vector<std::string> warnings = transfer_warnings(result, request_.input);
    run_.warnings.insert(run_.warnings.end(), warnings.begin(), warnings.end());
    run_.transfer = request_.fields.method;
    run_.field_accounts = std::move(result.accounts);
    fields_ = std::move(result.fields);
  }

  int finish() {
    progress_.finish();
    run_.times.total = total_.lap();
    run_.peak_memory = peak_memory_bytes();
    int code = run_.missed.empty() ? kDone : kGoalNotMet;
    if (memory_) gather_machines(*dataflow_exchange_, memory_->stop(), record_);
    if (first() && keeps_record()) {
      try {
        write_accounts();
      } catch (const meshing::InputError& error) {
        fmt::print(stderr, "weft: {}\n", meshing::printable(error.what()));
        code = kGoalNotMet;
      }
    }
    return code;
  }

  void write_accounts() {
    if (!request_.graph.empty()) {
      write_graph(request_.graph, record_.graph);
      write_planned_graph(planned_path(request_.graph), record_.planned);
    }
    if (!request_.trace.empty()) write_trace(request_.trace, record_, rank_.plan);
    if (run_.report_path.empty()) return;
    write_text(run_.report_path, json_of(run_).dump(1) + "\n");
    write_record(run_, record_, request_.case_name);
  }

  const AdaptRequest& request_;
  const SubdomainRequest& subdomains_;
  InterruptGuard interrupt_;
  Progress progress_;
  graph::adaptation::ProgressBoard news_;
  std::optional<graph::adaptation::ProgressTable> table_;  ///< on rank 0, while it adapts
  Stopwatch total_, watch_;
  RankData rank_;
  engine::Registry registry_;
  std::optional<engine::Runtime> runtime_;
  std::optional<engine::ShowStateOnSignal> show_state_;
  std::optional<EnginePeers> peers_;
  std::optional<graph::dataflow::RankExchange> dataflow_exchange_;
  DistributedResult result_;
  std::shared_ptr<DistributedStats> account_;
  RunRecord record_;
  std::optional<report::MemorySampler> memory_;
  meshing::MeshData whole_;  ///< the input, on rank 0, where fields have to be carried along
  meshing::SolutionData fields_;
  RunResult run_;
};

int refuse(const engine::Transport& transport, const std::exception& error) {
  if (transport.rank().value == 0) fmt::print(stderr, "weft: {}\n", meshing::printable(error.what()));
  return kNoMesh;
}

/// What all ranks throw alike ends here. Other exceptions may be those of one rank alone, for which the
/// others would wait: launch() takes them down.
int run_on_rank(const AdaptRequest& request, const SubdomainRequest& subdomains, bool quiet,
                engine::Transport& transport) {
  try {
    DistributedJob job(request, subdomains, transport);
    const int code = job.run();
    if (job.first() && !quiet) fmt::print("{}", summary_text(job.account()));
    return code;
  } catch (const meshing::InputError& error) {
    return refuse(transport, error);
  } catch (const std::invalid_argument& error) {
    return refuse(transport, error);
  } catch (const partition::InvariantViolation& error) {
    return refuse(transport, error);
  }
}

}  // namespace

bool in_subdomains(const SubdomainRequest& request) {
  return request.subdomains > 0 || !request.partitioner.empty() || engine::under_mpirun();
}

int run_in_subdomains(const AdaptRequest& request, const SubdomainRequest& subdomains, bool quiet) {
  try {
    partition::parse_partitioner(partitioner_of(subdomains), subdomains.subdomains);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError("--partitioner", error.what());
  }
  return engine::launch(0, nullptr, [&](engine::Transport& transport) {
    return run_on_rank(request, subdomains, quiet, transport);
  });
}

}  // namespace weft::tools

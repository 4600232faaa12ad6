// All ranks read, adapt, measure and write together; rank 0 makes the account.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/json/json.h"
#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/ugrid.h"
#include "meshing/metric/measures.h"
#include "partition/communication/agreement.h"
#include "partition/communication/point_limit.h"
#include "partition/communication/reduce.h"
#include "partition/fields/measure_slices.h"
#include "partition/fields/piece_slices.h"
#include "partition/output/merge_pieces.h"
#include "partition/output/output.h"
#include "partition/output/piece_files.h"
#include "tools/common/naming.h"
#include "tools/library/jobs/distributed_run.h"
#include "tools/library/jobs/file_job.h"
#include "tools/library/jobs/file_outputs.h"
#include "tools/library/jobs/resources/memory.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/jobs/sources/shares.h"
#include "tools/library/jobs/sources/slice_source.h"
#include "tools/library/jobs/world.h"
#include "tools/library/parts/piece_moves.h"
#include "tools/library/report/report_json.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;

Keep what_to_keep(const Files& files) {
  const bool report = !files.report.empty();
  const bool page = report && files.page, graph = !files.graph.empty(), trace = !files.trace.empty();
  return {.by_rank = report || graph || trace,
          .record = page || graph || trace,
          .timelines = page || trace,
          .plan = graph,
          .view = page};
}

/// One run on one rank. All ranks do the same steps; only rank 0's account is complete.
class DistributedFileJob {
 public:
  DistributedFileJob(const Files& files, const Options& options, engine::Transport& transport,
                     Monitor::Clock::time_point begin = Monitor::Clock::now())
      : files_(files),
        options_(options),
        keep_(what_to_keep(files)),
        account_(begin_run(files, options)),
        run_(options, transport, keep_, begin) {}

  FilesResult run() {
    agree_on_files();
    agree_on_outputs();
    SliceInput input = read();
    const double target = input.target_complexity;
    keep_for_fields(input);
    const auto measure_input = [&](const partition::MeshSlice& slice) {
      if (!input.background) measure_before(slice, target);
    };
    run_.adapt(std::move(input.slice), target, files_.input, account_,
               input.background ? &*input.background : nullptr, measure_input);
    watch_.lap();
    run_.on_threads([&] {
      if (!files_.fields.empty()) carry_fields();
      if (writes_one_file()) begin_writing();
    });
    // Who interrupts a run may soon kill it: the mesh first.
    const bool write_first = account_.cancelled && written_by_all();
    if (write_first) write();
    if (is_measured())
      run_.measure(account_);
    else
      run_.count(account_);
    account_.times.measure += watch_.lap();
    if (!write_first) write();
    finish();
    return files_result(account_, report_error_, run_.first());
  }

 private:
  /// What is read and written decides what all ranks do together.
  void agree_on_files() {
    const auto given = [](const std::string& path) { return path.empty() ? "none" : "some"; };
    const std::string mine = fmt::format(
        "input {}, output {}, background {}, fields {}, report {}, page {}, graph {}, trace {}", files_.input,
        files_.output, files_.background, fmt::join(files_.fields, " "), given(files_.report),
        files_.page ? "some" : "none", given(files_.graph), given(files_.trace));
    const std::string first = partition::text_of_first(run_.peers(), mine);
    partition::agree(run_.peers(),
                     mine == first ? "" : fmt::format("files differ: {}; on rank 0: {}", mine, first));
  }

  /// Rank 0 looks at them; what is wrong with an option all throw as such.
  void agree_on_outputs() {
    std::string option, reason;
    partition::agree_on(run_.peers(), [&] {
      if (!run_.first()) return meshing::require_part(account_.outputs.mesh);  // on any host
      try {
        check_outputs(files_, options_, account_.outputs);
      } catch (const OptionError& error) {
        option = error.option();
        reason = error.reason();
      }
    });
    option = partition::text_of_first(run_.peers(), option);
    if (!option.empty()) throw OptionError(option, partition::text_of_first(run_.peers(), reason));
  }

  SliceInput read() {
    run_.monitor().update("reading", 0, 0);
    meshing::MeshData carrier;  // whatever model there is, the one that the file carries stays in it
    partition::agree_on(run_.peers(), [&] {
      if (run_.first() && !options_.geometry.model.empty())
        carried_ = meshing::read_carried_model(files_.input);
    });
    carrier.association.model = carried_.model;
    const auto model = run_.read_model(carrier, files_.input);
    SliceInput input = run_.on_threads([&] {
      return read_slice(run_.peers(), files_, options_, model,
                        flag_for_metric(run_.monitor(), options_.checkpoint));
    });
    account_.warnings = input.warnings;
    if (std::string other = carry_model(options_.geometry, carried_); !other.empty())
      account_.warnings.push_back(std::move(other));
    account_.surface_limit = input.surface_limit;
    account_.mends = input.mends;
    names_ = std::move(input.names);
    std::ranges::move(
        loss_warnings(account_.outputs.mesh, files_.input, counts_of_slices(run_.peers(), input.slice),
                      names_, !options_.geometry.model.empty()),
        std::back_inserter(account_.warnings));
    warn_of_left_fields();
    account_.input_counts = {input.slice.num_points, input.slice.num_tets, input.slice.num_triangles,
                             input.slice.num_edges};
    account_.times.metric = input.metric_seconds;
    account_.times.read = watch_.lap() - input.metric_seconds;
    return input;
  }

  /// Rank 0 makes the account. The mesh has been read: what keeps these from being told is no fault.
  void warn_of_left_fields() {
    if (!run_.first() || !files_.fields.empty()) return;
    try {
      const Fields own = meshing::field_heads(files_.input);
      std::ranges::move(left_fields_warnings(files_, options_, own), std::back_inserter(account_.warnings));
    } catch (const std::exception&) {
    }
  }

  void measure_before(const partition::MeshSlice& slice, double target_complexity) {
    if (!is_measured()) return;
    watch_.lap();
    account_.before = partition::measure_slices(run_.peers(), slice, target_complexity);
    account_.times.measure = account_.times.measure_input = watch_.lap();
  }

  /// The account is of measures.
  bool is_measured() const { return options_.run.measure || keep_.by_rank; }

  /// Points, tets and fields of the input stay in shares until the result is there.
  void keep_for_fields(SliceInput& input) {
    if (files_.fields.empty()) return;
    run_.monitor().expect(seconds_to_carry(options_.transfer) / std::max(1, options_.run.threads));
    old_ = partition::without_boundary(input.slice);
    fields_ = std::move(input.fields);
  }

  bool writes_pieces() const { return fs::path(account_.outputs.mesh).extension() == ".pvtu"; }
  bool writes_one_file() const { return partition::can_write_pieces(account_.outputs.mesh); }
  bool written_by_all() const { return writes_pieces() || writes_one_file(); }

  void carry_fields() {
    run_.monitor().update("fields", 1, 0);
    const partition::Numbering& numbering = run_.numbering();
    if (const std::string issue = partition::too_many_points(numbering.totals.points); !issue.empty()) {
      report_error_ = "fields are not carried to the result: " + issue;  // which is not lost with them
      old_ = {};
      fields_ = {};
      return;
    }
    partition::MeshSlice slice = partition::slice_of_pieces(run_.peers(), run_.pieces(), numbering);
    meshing::Transfer result = naming(files_.input, [&] {
      return run_.carry(std::move(old_), fields_, slice, account_.left_as_is.has_value());
    });
    account_for_transfer(result, options_.transfer, files_.input, account_);
    fields_ = std::move(result.fields);
    piece_fields_ = partition::fields_of_pieces(run_.peers(), slice, numbering, fields_);
    piece_fields_.file = account_.outputs.fields;
    account_.times.fields = watch_.lap();
  }

  /// On ranks that have a thread for it bytes go out while the result is measured; where nothing is, before
  /// they are out, all threads write.
  void begin_writing() {
    output_.emplace(run_.peers(), run_.pieces(), run_.numbering(), account_.outputs.mesh,
                    account_.outputs.solution, carried_, 0, names_, piece_fields_);
    if (is_measured() && !account_.cancelled && run_.has_spare_thread())
      writing_ = std::jthread([this] { with_threads(1, [this] { output_->write(); }); });
    account_.times.write = watch_.lap();
  }

  void write() {
    run_.monitor().update("writing", 1, account_.output_counts.tets);
    run_.on_threads([&] {
      if (output_) {
        end_writing();
      } else if (writes_pieces()) {
        partition::write_pieces_as_vtu(run_.peers(), run_.pieces(), account_.outputs.mesh, piece_fields_);
      } else {
        write_by_first();
      }
    });
    account_.times.write += watch_.lap();
  }

  void end_writing() {
    if (writing_.joinable())
      writing_.join();
    else
      output_->write();
    output_->finish(run_.peers());
    if (run_.first()) copy_names();
  }

  /// Formats that one program writes: rank 0 gets the whole mesh.
  void write_by_first() {
    const Fields fields = gather_to_first(run_.peers(), fields_);
    const std::vector<partition::MeshPiece> pieces = gather_pieces(run_.exchange(), std::move(run_.pieces()));
    partition::agree_on(run_.peers(), [&] {
      if (!run_.first()) return;
      partition::MergedMesh merged = partition::merge_pieces(pieces);
      merged.mesh.association.model = carried_.model;
      merged.mesh.association.model_in_words = carried_.model_in_words;
      write_mesh_with_solution(account_.outputs, merged.mesh,
                               meshing::solution_from_metric(merged.log_metrics), fields, names_);
      copy_names();
    });
  }

  /// Of the UGRID format, in a file beside. The mesh is there already.
  void copy_names() {
    try {
      meshing::copy_mapbc(files_.input, account_.outputs.mesh);
    } catch (const meshing::InputError& error) {
      report_error_ = error.what();
    }
  }

  void finish() {
    account_.times.total = total_.lap();
    account_.peak_memory = partition::max(run_.peers(), peak_memory_bytes());
    run_.gather_machines();
    run_.account_for_exchanges();
    if (!run_.first() || !keep_.by_rank) return;
    try {
      write_accounts();
    } catch (const std::bad_alloc&) {
      report_error_ = "not enough memory to report the result";
    } catch (const std::exception& error) {
      report_error_ = error.what();
    }
  }

  void write_accounts() {
    RunRecord& record = run_.record();
    if (!files_.graph.empty()) {
      write_graph(files_.graph, record.graph);
      write_planned_graph(planned_path(files_.graph), record.planned);
    }
    if (!files_.trace.empty()) write_trace(files_.trace, record, run_.plan());
    if (account_.report_path.empty()) return;
    write_text(account_.report_path, text_of(json_of(account_), 1) + "\n");
    if (files_.page) run_.on_threads([&] { write_record(account_, record, files_.case_name); });
  }

  const Files& files_;
  const Options& options_;
  Keep keep_;
  Stopwatch total_, watch_;
  RunResult account_;
  DistributedRun run_;
  std::string report_error_;
  partition::MeshSlice old_;  ///< points and tets of the input, where fields have to be carried along
  Fields fields_;             ///< at the points of slices, of the input and then of the result
  partition::PieceFields piece_fields_;
  meshing::Association carried_;  ///< the CAD model in the input, on rank 0
  meshing::RefNames names_;       ///< of the input's references; on rank 0 at least
  std::optional<partition::PiecesOutput> output_;
  std::jthread writing_;  ///< after what it writes, so that it ends before that
};

/// Of ranks in one process the first alone says how far it is and hears the caller, and none watches the
/// machine.
Options options_of_simulated(const Options& options, engine::Rank rank) {
  Options mine = options;
  mine.run.state_on_signal = false;
  mine.run.max_memory = std::numeric_limits<double>::infinity();
  if (rank.value == 0) return mine;
  mine.run.progress = {};
  mine.run.cancel = nullptr;
  mine.run.on_failure = {};
  return mine;
}

}  // namespace

FilesResult adapt_files_in_subdomains(const Files& files, const Options& options) {
  FilesResult result;
  const auto begin = Monitor::Clock::now();  // MPI takes a while to start
  on_world_telling([&](engine::Transport& transport) {
    result = DistributedFileJob(files, options, transport, begin).run();
  });
  return result;
}

FilesResult adapt_files_on_simulated_ranks(const Files& files, const Options& options,
                                           const engine::SimulationOptions& simulation,
                                           engine::SimulationResult& simulated) {
  FilesResult result;
  telling(true, [&] {
    const auto simulate = [&] {
      return on_simulated_ranks(simulation, [&](engine::Transport& transport) {
        const Options mine = options_of_simulated(options, transport.rank());
        FilesResult of_rank = DistributedFileJob(files, mine, transport).run();
        if (transport.rank().value == 0) result = std::move(of_rank);
      });
    };
    simulated = with_threads(1, simulate);  // what other threads did would cost a rank nothing
  });
  return result;
}

}  // namespace weft::tools

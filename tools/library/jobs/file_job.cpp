// Checks, reads, adapts, writes, reports.
#include "tools/library/jobs/file_job.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "engine/json/json.h"
#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/ugrid.h"
#include "tools/library/jobs/adapt_one.h"
#include "tools/library/jobs/file_outputs.h"
#include "tools/library/jobs/resources/memory.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/run_work.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/jobs/sources/repaired_input.h"
#include "tools/library/report/report_json.h"
#include "tools/library/report/run_record.h"

namespace weft::tools {
namespace {

using meshing::InputError;
using meshing::MeshData;

/// The steps in order.
class FileJob {
 public:
  FileJob(const Files& files, const Options& options)
      : files_(files), options_(options), monitor_(options.run), run_(begin_run(files, options)) {}

  FilesResult run() {
    check_outputs(files_, options_, run_.outputs);
    with_threads(number_of_threads(options_.run.threads), [this] { read(); });
    adapt();
    write();
    measure();
    finish();
    return files_result(run_, report_error_);
  }

 private:
  void read() {
    monitor_.update("reading", 0, 0);
    const auto wanted = options_.run.repair ? meshing::Coordinates::any : meshing::Coordinates::finite;
    read_input(wanted);
    if (!files_.background.empty() && !same_file(files_.background, files_.input))
      background_ = meshing::read_mesh(files_.background, nullptr, wanted);
    if (input_.tets.empty()) throw InputError(files_.input, "", "has no tetrahedra");
    fields_ = read_all_fields(files_.fields, input_.points.size(), files_.input);
    if (options_.run.repair) mend();
    read_seconds_ = watch_.lap();
  }

  /// Fields that it holds itself are left out here, and told of.
  void read_input(meshing::Coordinates wanted) {
    meshing::MeshContents contents = meshing::read_mesh_contents(files_.input, wanted);
    meshing::refuse_foreign_volumes(contents.foreign_volumes, files_.input);
    left_fields_ = left_fields_warnings(files_, options_, contents.fields);
    names_ = std::move(contents.names);
    input_ = std::move(contents.mesh);
  }

  void mend() {
    MetricOptions none;
    RepairedMetric repaired =
        repair_input(input_, files_.input, background_ ? none : options_.metric, fields_);
    mends_ = std::move(repaired.mends);
    if (background_) {
      repaired = repair_background(*background_, files_.background, options_.metric);
      mends_.insert(mends_.end(), repaired.mends.begin(), repaired.mends.end());
    }
    source_ = std::move(repaired.source);
  }

  void adapt() {
    const AdaptInput input{input_,
                           files_.input,
                           background_ ? &*background_ : nullptr,
                           files_.background,
                           source_ ? &*source_ : nullptr,
                           fields_,
                           &model_,
                           &input_};
    const meshing::ContentCounts counts = meshing::counts_of(input_);
    result_ = adapt_one(input, options_, monitor_);
    if (std::string other = carry_model(options_.geometry, result_.mesh.association); !other.empty())
      result_.warnings.push_back(std::move(other));
    result_.times.read = read_seconds_;
    result_.mends = std::move(mends_);
    std::ranges::move(
        loss_warnings(run_.outputs.mesh, files_.input, counts, names_, !options_.geometry.model.empty()),
        std::back_inserter(result_.warnings));
    std::ranges::move(left_fields_, std::back_inserter(result_.warnings));
    fields_ = {};
    watch_.lap();
  }

  void write() {
    RunWork work = RunWork::to_complexity(static_cast<double>(result_.input_counts.tets),
                                          result_.target_complexity, !result_.fields.fields.empty());
    work.adapted(static_cast<double>(result_.output_counts.tets));
    monitor_.update("writing", work.at_writing(), result_.output_counts.tets);
    write_mesh_with_solution(run_.outputs, result_.mesh, result_.metric.fields(), result_.fields, names_);
    once_written([this] { meshing::copy_mapbc(files_.input, run_.outputs.mesh); });
    result_.times.write = watch_.lap();
  }

  /// What was ended early has not been: who interrupts a run may soon kill it, so the mesh came first.
  void measure() {
    if (options_.run.measure || !run_.report_path.empty()) once_written([this] { measures(result_); });
    static_cast<Report&>(run_) = std::move(static_cast<Report&>(result_));
  }

  void finish() {
    run_.times.total = total_.lap();
    run_.peak_memory = peak_memory_bytes();
    if (run_.report_path.empty()) return;
    once_written([this] {
      write_text(run_.report_path, text_of(json_of(run_), 1) + "\n");
      if (!files_.page) return;
      with_threads(number_of_threads(options_.run.threads), [this] {
        write_record(run_, record_of(result_.mesh, result_.metric.logarithms(), model_.get()),
                     files_.case_name);
      });
    });
  }

  /// The mesh is safe by now: a report that cannot be made costs the goal, not the mesh.
  template <class F>
  void once_written(F f) {
    try {
      f();
    } catch (const std::bad_alloc&) {
      report_error_ = "not enough memory to measure and report the result";
    } catch (const std::exception& error) {
      report_error_ = error.what();
    }
  }

  const Files& files_;
  Options options_;  ///< as asked for; when the input is mended, without the files that have been read
  Monitor monitor_;
  Stopwatch total_, watch_;
  RunResult run_;
  std::shared_ptr<const meshing::Model> model_;  ///< null: there is none
  double read_seconds_ = 0;
  std::string report_error_;
  MeshData input_;
  std::optional<meshing::LogMetricField> source_;  ///< the metric that was mended with the input
  std::vector<Mend> mends_;
  meshing::RefNames names_;               ///< of the input's references, which the result keeps
  std::vector<std::string> left_fields_;  ///< warnings of the input's own
  std::optional<MeshData> background_;    ///< empty: the input
  meshing::SolutionData fields_;          ///< of the input, to be carried along
  Result result_;
};

}  // namespace

FilesResult adapt_files_as_one(const Files& files, const Options& options) {
  return FileJob(files, options).run();
}

}  // namespace weft::tools

// A run in subdomains on one rank or many: the engine, the method, and what is gathered of it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/network/transport.h"
#include "engine/run/runtime.h"
#include "engine/run/show_state_on_signal.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "graph/dataflow/rank_exchange.h"
#include "meshing/fields/transfer.h"
#include "partition/output/numbering.h"
#include "partition/slice/mesh_slice.h"
#include "tools/library/jobs/monitor.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/report/run_record.h"
#include "weft/weft.h"

namespace weft::tools {

/// What a run keeps for its account beside sums over all ranks.
struct Keep {
  bool by_rank = false;    ///< figures of each rank
  bool record = false;     ///< the executed graph, memory; with `by_rank`
  bool timelines = false;  ///< beside the record
  bool plan = false;       ///< the planned graph
  bool view = false;       ///< the mesh, thinned out, for the page
};

/// One rank's part of a run. All ranks call the same functions in the same order. What all throw alike are
/// meshing::InputError, std::invalid_argument and engine::RunFailure.
class DistributedRun {
 public:
  /// `begin`: from when a limit of time counts.
  DistributedRun(const Options& options, engine::Transport& transport, const Keep& keep = {},
                 Monitor::Clock::time_point begin = Monitor::Clock::now());

  partition::Peers& peers() { return *peers_; }
  graph::dataflow::RankExchange& exchange() { return *exchange_; }
  bool first() const { return runtime_->rank().value == 0; }
  Monitor& monitor() { return monitor_; }

  /// Does work on the threads of this rank: other ranks have the other cores. Those of a caller who asks for
  /// no number stay. Simulated ranks take turns within one thread, where an arena would be left by another
  /// rank than has entered it.
  template <class Work>
  auto on_threads(const Work& work) const {
    const bool all_are_here = runtime_->ranks() == 1 && options_.run.threads <= 0;
    if (shares_its_thread_ || all_are_here) return work();
    return with_threads(threads_, work);
  }

  /// Whether work that asks no other rank may be done beside the steps: this rank has more threads than one.
  bool has_spare_thread() const {
    return !shares_its_thread_ && on_threads([] { return tbb::this_task_arena::max_concurrency(); }) > 1;
  }

  /// Reads the CAD model that the options name, on every rank. `mesh` of
  /// rank 0 may carry it; errors call it `name`. To be called before adapt(). Throws on all ranks where one
  /// fails.
  std::shared_ptr<const meshing::Model> read_model(const meshing::MeshData& mesh, const std::string& name);
  /// Adapts the mesh of the slices, which errors call `name`; fills pieces and `report`. `background`: slices
  /// of another mesh that has the metric, with which nothing is to be done any more; null: the mesh has it.
  /// `measure_input`: called with the slice, unless the mesh is left as it is.
  void adapt(partition::MeshSlice&& slice, double target_complexity, const std::string& name, Report& report,
             partition::MeshSlice* background = nullptr,
             const std::function<void(const partition::MeshSlice&)>& measure_input = {});
  /// Carries fields at the points of the slices of `from` to those of `to`, which are the result's: of the
  /// same mesh where it was left as it is. May give the memory of `from` and of the tets of `to` back.
  meshing::Transfer carry(partition::MeshSlice&& from, const meshing::SolutionData& fields,
                          partition::MeshSlice& to, bool same_mesh);
  /// Fills the measures of the result, and what they say of the goal. Those of the input too, where they are
  /// the same.
  void measure(Report& report);
  /// Fills the numbers of its entities alone.
  void count(Report& report);

  std::vector<partition::MeshPiece>& pieces() { return result_.pieces; }
  /// Of the pieces, made when first asked for, by all ranks.
  const partition::Numbering& numbering();
  const graph::adaptation::AdaptationPlan& plan() const { return rank_.plan; }
  RunRecord& record() { return record_; }
  /// The last exchange: what was exchanged after the loop goes into the account.
  void account_for_exchanges();
  /// What the ranks know of their machines goes into the record.
  void gather_machines();

 private:
  /// All ranks: whether the mesh of the slices is the result as it is, which is filled then.
  bool leave_as_is(const partition::MeshSlice& slice, const graph::adaptation::DistributedOptions& method,
                   Report& report);
  /// What has been freed goes back to the system, unless other ranks are in this process.
  void give_back_freed_memory() const;
  engine::Bulletins bulletins();
  std::string name_of(engine::ObjectId id) const;
  std::uint32_t number_of_subdomains();
  std::uint64_t hash_of_program() const;
  graph::adaptation::DistributedOptions method_options(double target_complexity);
  void agree_on_options();
  void find_checkpoints();
  void add_checkpoint(const std::string& text);
  /// The number of subdomains is the checkpoint's.
  void warn_of_other_subdomains(Report& report) const;
  void account_for_checkpoints(const engine::RunSummary& sums, Report& report);
  void check_room(const std::string& name, Report& report);
  void gather_statistics(Report& report);

  const Options& options_;
  Keep keep_;
  int threads_;
  bool shares_its_thread_;
  Monitor monitor_;
  bool tells_ = false;  ///< rank 0 is to hear how far all ranks are
  graph::adaptation::ProgressBoard news_;
  std::optional<graph::adaptation::ProgressEstimator> estimator_;  ///< on rank 0, while it adapts
  graph::adaptation::RankData rank_;
  std::optional<graph::adaptation::CheckpointWriter> checkpoints_;
  std::vector<graph::adaptation::CheckpointPlace> resume_;  ///< of one run, the latest first
  engine::Registry registry_;
  std::optional<engine::Runtime> runtime_;
  std::optional<engine::ShowStateOnSignal> show_state_;
  std::optional<graph::adaptation::EnginePeers> peers_;
  std::optional<graph::dataflow::RankExchange> exchange_;
  std::shared_ptr<const meshing::Model> model_;  ///< null: the surface is reconstructed
  graph::adaptation::DistributedResult result_;
  std::optional<partition::Numbering> numbering_;  ///< of the result's pieces
  engine::RankSummary before_loop_, after_loop_;   ///< of this rank
  std::shared_ptr<DistributedStats> stats_;
  RunRecord record_;
  std::optional<report::MemorySampler> memory_;
};

/// The partitioner that options mean.
std::string partitioner_of(const DistributedOptions& options);

}  // namespace weft::tools

// The distributed method from every rank's share of the input to every rank's pieces of the result.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/run/runtime.h"
#include "graph/adaptation/checkpoint_writer.h"
#include "graph/adaptation/engine_peers.h"
#include "graph/adaptation/subdomain_task.h"
#include "graph/dataflow/execution_log.h"
#include "meshing/fields/coverage.h"
#include "partition/distribute/distribute.h"
#include "partition/output/sum_on_model.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::graph::adaptation {

struct DistributedOptions {
  partition::DecompositionOptions decomposition;
  /// This rank's slice of another mesh that has the metric, which is taken; null on all ranks: the input has
  /// it. Not to be scaled any more then (DecompositionOptions::target_complexity).
  partition::MeshSlice* background = nullptr;
  partition::ShiftOptions shift;
  std::uint32_t most_shifts = kMostShifts;
  bool refine_interface = true;
  bool tets_at_frozen_stay = false;  ///< meshing::AdaptOptions
  meshing::AllowedOperations allowed = {};
  double hausd = 0;  ///< meshing::AdaptOptions
  /// Where few subdomains make a coarse mesh that is divided: at most so many tets for each, of the input or
  /// of that mesh. More would be a burden for one rank.
  double tets_of_seed = 1e5;
  int threads = 1;  ///< of this rank
  dataflow::Recording recording = dataflow::Recording::on;
  ProgressBoard* news = nullptr;  ///< of this rank
  /// Called when the decomposition is done and the plan made; may throw on all ranks alike.
  std::function<void()> on_plan = {};
  std::function<void()> on_start = {};  ///< called after that
  std::function<void()> on_end = {};    ///< called when the loop has ended, before anything else is exchanged
  /// Checks the invariants of all subdomains (partition/verify/check_subdomains.h) after the decomposition,
  /// the adaptation of the interiors, and every shift, for which all ranks wait for each other. The result is
  /// the same.
  bool check = false;
  /// Called with each subdomain that is here before each of these checks: to look at them, or to see that
  /// damage is found.
  std::function<void(partition::Subdomain&)> on_check = {};
  const std::atomic<bool>* interrupt = nullptr;
  std::function<void()> out_of_memory = {};  ///< meshing::AdaptOptions::out_of_memory, from any thread
  /// Of the runtime (RuntimeOptions::snapshots); null: no checkpoints.
  CheckpointWriter* checkpoints = nullptr;
  /// To go on from, the same on all ranks and of one run: the first that is not damaged. Empty: from the
  /// beginning.
  std::vector<CheckpointPlace> resume;
  /// Whatever else must be the same when a run goes on from a checkpoint: a hash of it.
  std::uint64_t program = 0;
};

/// A subdomain and those that share its interface.
struct Neighbours {
  partition::SubdomainId subdomain;
  std::vector<partition::SubdomainId> others;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(subdomain, others);
  }
};

/// Result of this rank.
struct DistributedResult {
  std::vector<partition::MeshPiece> pieces;
  std::vector<std::vector<std::uint8_t>> was_interface;  ///< a flag for each point of each piece
  std::vector<std::vector<ShiftRecord>> shifts;          ///< of each piece
  double surface_deviation = 0;  ///< of the pieces here: largest distance of a triangle's centroid
  std::vector<partition::PieceOnModel> on_model;  ///< of each piece, where the boundary has a model
  meshing::ModelFaults input_on_model;            ///< the same on all ranks
  meshing::OperationCounts counts;                ///< of all subdomains that are here now
  std::vector<Neighbours> planned;    ///< of the subdomains that were here after the decomposition
  std::vector<std::string> warnings;  ///< the same on all ranks
  meshing::Uncovered uncovered;       ///< of the input, by a background of its own; likewise
  std::uint32_t checks = 0;           ///< how many times all invariants were checked, and held
  std::filesystem::path resumed;      ///< the checkpoint that it has gone on from; empty: none
  bool cut_by_runs = false;  ///< the mesh was nearly as wanted (partition::Partitioner::runs_suffice)
  double decomposition_seconds = 0, adaptation_seconds = 0;
};

/// On all ranks, before the runtime starts.
void register_adaptation(engine::Registry& registry);

/// Decomposes the mesh, adapts all subdomains and their interfaces, and leaves every rank what it has then.
/// All ranks call it, with one runtime whose RuntimeOptions::local is `rank` (which this fills) and which has
/// no objects but those of `peers`. Throws on all ranks: what distribute() throws,
/// partition::InvariantViolation where a check fails, engine::RunFailure.
DistributedResult adapt_distributed(engine::Runtime& runtime, EnginePeers& peers, RankData& rank,
                                    partition::MeshSlice&& slice, const DistributedOptions& options);

/// The runs of all nodes on this rank, after adapt_distributed().
dataflow::ExecutionLog execution_log(engine::Runtime& runtime);

}  // namespace weft::graph::adaptation

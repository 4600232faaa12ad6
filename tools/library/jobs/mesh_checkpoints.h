// Checkpoints of one mesh in this process: the state of its adaptation between two passes, in the files of
// graph/adaptation/checkpoint_files.h, as one rank's only record.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "graph/adaptation/checkpoint_writer.h"
#include "meshing/adapt/adapt.h"
#include "weft/weft.h"

namespace weft::tools {

/// The same for runs that may go on from each other's checkpoints. `metric`: of `background`.
std::uint64_t hash_of_run(const meshing::MeshData& input, const meshing::MeshData& background,
                          const meshing::LogMetricField& metric, const Options& options);

/// Packs and writes a state in a thread of its own while the adaptation goes on. What cannot be written costs
/// the checkpoint, not the run.
class MeshCheckpoints final : public meshing::StateKeeper {
 public:
  MeshCheckpoints(const CheckpointOptions& options, std::uint64_t run);
  ~MeshCheckpoints() override;

  bool wanted() override;
  void keep(const std::function<meshing::AdaptationState()>& copy) override;
  /// The last one is on the disk; fills `stats`.
  void finish(CheckpointStats& stats);

 private:
  void write(meshing::AdaptationState&& state);
  void finish_epoch(bool whole);

  graph::adaptation::CheckpointWriter writer_;
  std::uint64_t epoch_ = 0;
  double seconds_ = 0;  ///< that the adaptation has waited for copies
  std::atomic<bool> busy_ = false;
  bool lost_ = false;  ///< the latest; of whoever writes
  std::thread background_;
};

/// A state to go on from, and where it was.
struct FoundState {
  meshing::AdaptationState state;
  std::string folder;
};

/// The latest checkpoint in `folder` that is not damaged; for every one that is a warning. Empty: there is
/// none. Throws InputError where all are damaged, or the latest is of another run.
std::optional<FoundState> find_state(const std::string& folder, std::uint64_t run,
                                     std::vector<std::string>& warnings);

}  // namespace weft::tools

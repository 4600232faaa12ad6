// Writes checkpoints of the subdomains while they work on.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "engine/schedule/snapshot.h"
#include "graph/adaptation/checkpoint_files.h"

namespace weft::graph::adaptation {

/// What has been written, as rank 0 knows it.
struct CheckpointsWritten {
  std::uint32_t written = 0;
  std::uint64_t bytes = 0;  ///< of the latest
  std::string failure;      ///< why the latest could not be; empty: it could
};

/// One rank's. Copies go to the rank's file as they come; flushing it to the disk, and on rank 0 the
/// manifest, are the matter of a thread of its own. What cannot be written costs the checkpoint, not the run.
class CheckpointWriter final : public engine::SnapshotSink {
 public:
  using Clock = std::chrono::steady_clock;

  /// `every`: seconds; 0: only when `now` is set, which may be null. The first ones come sooner, after 10
  /// seconds and each time twice that, so that a young run that is killed has one too.
  CheckpointWriter(std::filesystem::path folder, double every, std::atomic<bool>* now, int rank, int ranks);
  ~CheckpointWriter() override;

  /// From here on checkpoints are written, of a run that `manifest` names.
  void begin(const CheckpointManifest& manifest);
  /// No more.
  void end();
  /// On rank 0, when all ranks have ended: what has not become a checkpoint goes.
  void remove_unfinished() const;
  CheckpointsWritten written() const;
  const std::filesystem::path& folder() const { return folder_; }

  bool wanted() override;
  void object(std::uint64_t epoch, engine::Payload copy) override;
  void message(std::uint64_t epoch, engine::Payload copy) override;
  void close(std::uint64_t epoch) override;
  std::optional<bool> stored(std::uint64_t epoch) override;
  /// After close(): the same, waited for.
  bool wait_until_stored();
  void finish(std::uint64_t epoch, bool whole) override;
  void give_up() override;

 private:
  static constexpr std::size_t kKept = 2;

  void add(std::uint64_t epoch, CheckpointRecord::Kind kind, const engine::Payload& copy);
  template <class Work>
  void in_background(Work work);
  void schedule(double seconds);
  void write_manifest(const std::filesystem::path& folder);
  void fail(const std::string& why);

  const std::filesystem::path folder_;
  const double every_;
  std::atomic<bool>* const now_;
  const int rank_, ranks_;

  std::atomic<bool> active_ = false;
  bool pending_ = false;  ///< one is wanted or goes on; of the communication thread
  bool asked_ = false;    ///< for one that is not stored yet; `now` has been reset
  Clock::time_point next_;
  double interval_ = 0;  ///< seconds, of those up to next_
  CheckpointManifest manifest_;

  mutable std::mutex mutex_;
  std::unique_ptr<CheckpointFile> file_;
  std::uint64_t epoch_ = 0;  ///< of the file
  std::string failure_;      ///< of this rank, in this epoch
  CheckpointsWritten written_;
  std::thread background_;
  std::atomic<int> stored_ = -1;  ///< of this epoch: -1 not yet, 0 it failed, 1 it is
};

}  // namespace weft::graph::adaptation

// Writes checkpoints of the subdomains while they work on.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/schedule/snapshot.h"
#include "graph/adaptation/checkpoint_files.h"

namespace weft::graph::adaptation {

/// What has been written, as rank 0 knows it.
struct CheckpointsWritten {
  std::uint32_t written = 0;
  std::uint64_t bytes = 0;  ///< of the latest
  std::string failure;      ///< why the latest could not be; empty: it could
};

/// One rank's. Copies go to the rank's file as they come; messages, flushing it to the disk, and on rank 0
/// the manifest, are the matter of a thread of its own: neither the communication thread nor who holds the
/// scheduler's lock waits for a disk. What cannot be written costs the checkpoint, not the run.
class CheckpointWriter final : public engine::SnapshotSink {
 public:
  using Clock = std::chrono::steady_clock;

  /// `every`: seconds; 0: only when `now` is set, which may be null. The first ones come sooner, after 10
  /// seconds and each time twice that, so that a young run that is killed has one too. `interrupt`: the
  /// run's, or null; once it is set work is cut short, and nobody goes on from that: no checkpoint any more.
  CheckpointWriter(std::filesystem::path folder, double every, std::atomic<bool>* now,
                   const std::atomic<bool>* interrupt, int rank, int ranks);
  ~CheckpointWriter() override;

  /// On rank 0: no other run writes into the folder from now on. Throws meshing::InputError where one does.
  void lock();
  /// From here on checkpoints are written, of a run that `manifest` names.
  void begin(const CheckpointManifest& manifest);
  /// No more. Waits for what is being written, unless the run was interrupted: its mesh comes first.
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
  bool wait_until_stored(std::uint64_t epoch);
  void finish(std::uint64_t epoch, bool whole) override;
  void give_up() override;

 private:
  static constexpr std::size_t kKept = 2;

  /// Messages of an epoch, until all have come.
  struct Messages {
    std::mutex mutex;
    std::uint64_t epoch = 0;
    std::vector<engine::Payload> all;
    bool lost = false;  ///< there was no memory for one
  };

  bool interrupted() const { return interrupt_ != nullptr && *interrupt_; }
  void add(std::uint64_t epoch, CheckpointRecord::Kind kind, const engine::Payload& copy);
  void begin_epoch(std::uint64_t epoch);
  void open_file();
  bool add_messages(std::uint64_t epoch);
  bool store(std::uint64_t epoch);
  template <class Work>
  void in_background(Work work);
  void schedule(double seconds);
  void write_manifest(const std::filesystem::path& folder);
  void fail(const std::string& why);

  const std::filesystem::path folder_;
  const double every_;
  std::atomic<bool>* const now_;
  const std::atomic<bool>* const interrupt_;
  const int rank_, ranks_;
  std::optional<CheckpointLock> lock_;

  std::atomic<bool> active_ = false;
  bool pending_ = false;  ///< one is wanted or goes on; of the communication thread
  bool asked_ = false;    ///< for one that is not stored yet; `now` has been reset
  Clock::time_point next_;
  double interval_ = 0;  ///< seconds, of those up to next_
  CheckpointManifest manifest_;

  mutable std::mutex mutex_;
  std::unique_ptr<CheckpointFile> file_;
  std::uint64_t epoch_ = 0, given_up_ = 0;  ///< of the file; one that nobody wants any more
  std::string failure_;                     ///< of this rank, in this epoch
  CheckpointsWritten written_;
  Messages messages_;
  std::thread background_;                 ///< the latest, which waits for the one before
  std::atomic<std::uint64_t> stored_ = 0;  ///< the latest epoch that was, or failed (add 1), doubled
};

}  // namespace weft::graph::adaptation

// What a caller sees of a run while it lasts, and how it ends before it is done.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "weft/weft.h"

namespace weft::tools {

/// Why a run has ended early. The greater counts where ranks have different reasons.
enum class EndReason : std::uint8_t { none, interrupted, memory_limit, time_limit, out_of_memory };

/// "interrupted", "memory limit", "time limit", "out of memory", or empty.
std::string text_of(EndReason reason);

/// A tet, on one thread, with a margin: of two, as all else that comes after the adaptation.
constexpr double seconds_to_carry(TransferMethod method) {
  return method == TransferMethod::conservative ? 40e-6 : 1e-6;
}

/// Passes progress to the caller's function, on the calling thread; where that returns false the run is
/// cancelled. A thread of its own watches the caller's flag and limits of time and memory, and cancels the
/// run, at these while there is time to measure and write what it has.
class Monitor {
 public:
  using Clock = std::chrono::steady_clock;
  /// `sharers`: ranks that write the result together. Limits of time count from `begin`. `first`: this is
  /// rank 0, which alone tells the caller's function.
  explicit Monitor(const RunOptions& options, int sharers = 1, Clock::time_point begin = Clock::now(),
                   bool first = true);
  ~Monitor();
  Monitor(const Monitor&) = delete;
  Monitor& operator=(const Monitor&) = delete;

  void update(const std::string& stage, double done, std::uint64_t tets) { tell({stage, false, done, tets}); }
  void tell(const Progress& progress);
  /// Set once the run is to end with the mesh that it has: by the caller's flag, because its function said
  /// so, or by a limit. It is the run's own: who ends one run does not end the next one with these options.
  std::atomic<bool>& flag() { return flag_; }
  /// Set once the caller wants the run to end, whatever else has ended it: nothing long is to be begun for
  /// its result. (A limit of time leaves time for what was expected.)
  const std::atomic<bool>& caller_waits() const { return caller_waits_; }
  bool cancelled();
  EndReason reason();
  /// Ends the run: an allocation has failed. From any thread.
  void out_of_memory() { cancel(EndReason::out_of_memory); }
  /// Before the mesh is written, what takes so long for each of its tets has to be done on the ranks
  /// together.
  void expect(double seconds_of_tet) { seconds_of_tet_ = seconds_of_tet; }
  /// Whether progress has to be told, as this rank wishes: that of rank 0 counts.
  bool wanted() const { return options_.progress || options_.time_limit > 0; }

 private:
  using Seconds = std::chrono::duration<double>;

  void watch();
  Seconds watch_memory();
  /// Bytes that may still be taken before the run must end, and whether by the limit that was asked for or by
  /// what the machine has left.
  struct MemoryToTake {
    double bytes;
    bool as_asked;
  };
  /// None where the system does not tell.
  std::optional<MemoryToTake> memory_to_take() const;
  void cancel(EndReason reason);
  /// Passes the caller's flag on, which a signal handler may have set.
  void hear_caller();
  double seconds_to_finish() const;

  const RunOptions& options_;
  const int sharers_;
  const int sharers_here_;  ///< found at first: the environment may change while other threads run
  const Clock::time_point begin_;
  const bool first_;
  std::atomic<bool> flag_ = false, caller_waits_ = false;
  std::atomic<EndReason> reason_ = EndReason::none;
  std::atomic<std::uint64_t> tets_ = 0;     ///< the most that have been told of
  std::atomic<double> seconds_of_tet_ = 0;  ///< expect()
  double memory_ = 0;           ///< bytes that this process may take; 0: what is left, infinity: no matter
  double memory_at_begin_ = 0;  ///< that this process had
  double to_take_ = 0;          ///< memory_to_take() at the last look
  Clock::time_point looked_ = begin_;  ///< when that was
  double taken_per_second_ = 0;        ///< the most lately: halved at each look
  std::mutex mutex_;
  std::condition_variable over_;
  bool ended_ = false;
  std::thread watcher_;
};

/// What ends the making of a metric: nothing of a run with checkpoints, which are known by their metric.
inline const std::atomic<bool>* flag_for_metric(Monitor& monitor, const CheckpointOptions& checkpoint) {
  return checkpoint.folder.empty() && checkpoint.resume.empty() ? &monitor.flag() : nullptr;
}

}  // namespace weft::tools

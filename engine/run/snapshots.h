// How ranks agree on snapshots: when one begins, that all of it has come, that all have stored it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/base/rank.h"
#include "engine/schedule/scheduler.h"
#include "engine/schedule/snapshot.h"

namespace weft::engine {

/// A message between the parts of two ranks.
struct SnapshotMessage {
  enum class Kind : std::uint8_t {
    ready,   ///< to rank 0: the root is through, `objects` have been made here
    wish,    ///< to rank 0: this rank wishes a snapshot
    begin,   ///< of rank 0
    count,   ///< to rank 0
    close,   ///< of rank 0: nothing more will come
    stored,  ///< to rank 0
  } kind = Kind::ready;
  bool good = true;
  std::uint64_t epoch = 0;
  std::uint64_t objects = 0;
  std::uint64_t serial = 0;  ///< of a rank's counts: packets may overtake each other
  SnapshotCounts counts = {};
};

/// One rank's part. Called by its communication thread only.
class Snapshots {
 public:
  using Post = std::function<void(Rank to, const SnapshotMessage&)>;

  Snapshots(SnapshotSink& sink, Scheduler& scheduler, Rank rank, int ranks, Post post);

  /// What the last run has left unfinished is given up.
  void begin_run();
  /// In every turn of a run.
  void step();
  void receive(Rank from, const SnapshotMessage& message);

 private:
  enum class Stage : std::uint8_t { none, collecting, storing };

  void tell(Rank to, const SnapshotMessage& message);
  void tell_all(const SnapshotMessage& message);
  void begin_if_wanted();
  void tell_counts();
  void tell_stored();
  void note_counts(Rank from, const SnapshotMessage& message);
  void note_stored(const SnapshotMessage& message);

  SnapshotSink& sink_;
  Scheduler& scheduler_;
  const Rank rank_;
  const int ranks_;
  const Post post_;
  Stage stage_ = Stage::none;
  std::uint64_t epoch_ = 0;
  bool told_ready_ = false;
  std::optional<SnapshotCounts> told_;
  std::uint64_t last_serial_ = 0;

  // On rank 0.
  bool wished_ = false;
  bool closing_ = false;
  int not_ready_ = 0;
  std::uint64_t objects_ = 0;
  std::vector<SnapshotCounts> counts_;
  std::vector<std::uint64_t> serials_;  ///< of these
  int not_stored_ = 0;
  bool all_good_ = true;
};

}  // namespace weft::engine

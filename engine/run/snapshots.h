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
    count,   ///< to rank 0; `good`: after its word that all objects have been copied
    settle,  ///< of rank 0: all objects have been copied
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
  /// From now on no object is copied, whoever asks for it: the program may look at them.
  void end_run();

 private:
  enum class Stage : std::uint8_t { none, collecting, storing };
  /// What counts a rank has told: none yet, some, some taken after all objects had been copied.
  enum class Told : std::uint8_t { nothing, counts, final_counts };

  void tell(Rank to, const SnapshotMessage& message);
  void tell_all(const SnapshotMessage& message);
  void begin_if_wanted();
  bool tell_counts();
  bool all_have_told(Told least) const;
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
  bool over_ = true;
  bool told_ready_ = false;
  bool settled_ = false;  ///< all objects have been copied, on all ranks
  std::optional<SnapshotCounts> told_;
  std::uint64_t last_serial_ = 0;

  // On rank 0.
  bool wished_ = false;
  bool settling_ = false;
  bool closing_ = false;
  int not_ready_ = 0;
  std::uint64_t objects_ = 0;
  std::vector<SnapshotCounts> counts_;
  std::vector<std::uint64_t> serials_;  ///< of these
  std::vector<Told> rank_told_;         ///< what each rank has told of them
  int not_stored_ = 0;
  bool all_good_ = true;
};

}  // namespace weft::engine

// Finds out that a run has ended: nothing runs anywhere and no message flies.
//
// Mattern's four-counter method on a binary tree of ranks. Rank 0 starts a wave; it goes down the tree at
// once and comes back up, each rank answering when it is *passive* (no task runs or waits to run) with the
// messages it has sent and received so far, its children's added. If all messages *sent* by the end of a wave
// had been *received* at the previous one already, none was in flight in between, so nobody can have woken
// up: the run has ended. Proof: F. Mattern, Algorithms for distributed termination detection, Distributed
// Computing 2 (1987), section 6. No order of messages is needed. While any rank works, the wave waits there
// and nobody sends anything.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/base/rank.h"
#include "engine/trace/trace.h"

namespace weft::engine {

/// What a rank, or a whole subtree, tells at the end of a wave.
struct WaveCount {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t waiting = 0;  ///< objects that wait for something while nothing runs
};

/// A message between the detectors of two ranks.
struct WaveMessage {
  enum class Kind : std::uint8_t { probe, report, ended } kind = Kind::probe;
  std::uint64_t wave = 0;
  WaveCount count;
};

/// One rank's part. Called by its communication thread only.
class Termination {
 public:
  using Send = std::function<void(Rank to, const WaveMessage&)>;

  Termination(Rank rank, int ranks, Send send);

  void receive(Rank from, const WaveMessage& message);

  /// Goes on if it can; to be called when the rank's state may have changed and at `next_wave`. `count`: this
  /// rank's numbers, nothing when it is not passive.
  void step(const std::optional<WaveCount>& count, TimePoint time);

  /// Whether step() would get on if this rank is passive.
  bool due(TimePoint time) const {
    return !ended_ && ((probed_ && reports_missing_ == 0) || (next_wave_ && time >= *next_wave_));
  }

  /// When step() has to be called though nothing happens; nothing: never.
  std::optional<TimePoint> next_step() const { return next_wave_; }

  /// Set when the run has ended: the sums over all ranks at rank 0, elsewhere only `waiting`.
  const std::optional<WaveCount>& ended() const { return ended_; }

  /// For how long (nanoseconds) the waves that came back to rank 0 have told it the same, though not all that
  /// was sent has been received. Long means that the network has lost something. Time without waves, while
  /// ranks work, does not count: a wave before and one after it must agree. Nor does more than a second
  /// between two waves: the ranks may have been suspended.
  TimePoint futile_for() const { return futile_for_; }
  const WaveCount& last_sums() const { return previous_; }

 private:
  void start_wave();
  void finish_wave(TimePoint time);
  void end(const WaveCount& sums);
  template <class Visit>
  void each_child(Visit visit) const;

  Rank rank_;
  int ranks_;
  Send send_;
  std::uint64_t wave_ = 0;   ///< the latest known
  bool probed_ = false;      ///< a wave is here and has not gone on
  int reports_missing_ = 0;  ///< children that have not answered
  WaveCount sums_;           ///< of the children that have
  WaveCount previous_;       ///< rank 0: of the last complete wave
  bool has_previous_ = false;
  TimePoint last_back_ = 0;  ///< when the last wave came back
  TimePoint futile_for_ = 0;
  TimePoint backoff_ = 0;
  std::optional<TimePoint> next_wave_;
  std::optional<WaveCount> ended_;
};

}  // namespace weft::engine

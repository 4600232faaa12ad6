// What each thread of a rank did and when: counters always, spans on request.
#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/paged_table.h"
#include "engine/base/rank.h"
#include "engine/base/virtual_time.h"

namespace weft::engine {

/// Nanoseconds on the monotonic clock; of a simulated rank on its virtual one.
using TimePoint = std::int64_t;
inline TimePoint now() {
  if (const VirtualTime* simulated = VirtualTime::of_thread()) return simulated->now();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

enum class Activity : std::uint8_t {
  compute,      ///< a handler ran (worker)
  unpack,       ///< an object or a handler's arguments were read from a message (worker)
  pack,         ///< an object was written into a message (communication thread)
  communicate,  ///< the communication thread was awake
  help,         ///< a thread of TBB's was there for the parallel loops of handlers (helper)
};
inline constexpr std::size_t kActivities = 5;
const char* name_of(Activity activity);

/// What a message was for; counters are kept by it and by method.
enum class Traffic : std::uint8_t { invoke, signal, migrate, forward };
inline constexpr std::size_t kTraffics = 4;
const char* name_of(Traffic traffic);

/// One piece of a lane's time. `name` is a method's index in the registry, or kNoName.
struct Span {
  static constexpr std::uint32_t kNoName = 0xFFFFFFFFu;
  TimePoint begin = 0;
  TimePoint end = 0;
  ObjectId object;
  std::uint32_t name = kNoName;
  Activity activity = Activity::compute;
  std::uint64_t cause =
      0;  ///< id of the message that this span handles; 0: none. Joined to the Departure with this id.
};

/// A message was sent: the start of an arrow in a timeline.
struct Departure {
  TimePoint time = 0;
  std::uint64_t id = 0;    ///< unique in the run
  std::uint32_t lane = 0;  ///< of the rank, by Trace::lanes(): where it was sent from
};

/// Number and bytes of messages.
struct MessageCount {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  void add(std::uint64_t size) { ++messages, bytes += size; }
  template <class Archive>
  void serialize(Archive& archive) {
    archive(messages, bytes);
  }
};

/// Both directions of messages.
struct Volume {
  MessageCount sent;
  MessageCount received;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(sent, received);
  }
};

/// Runs of something: how many, their nanoseconds in all, and the longest one's.
struct TimeCount {
  std::uint64_t count = 0;
  std::int64_t total = 0;
  std::int64_t longest = 0;
  void add(std::int64_t nanoseconds) {
    ++count, total += nanoseconds;
    if (nanoseconds > longest) longest = nanoseconds;
  }
};

/// Entries up to a limit; those that come later are counted and dropped. Grows by chunks: copying old
/// entries, as a vector does, would show up in the times that are being measured.
template <class T>
class BoundedLog {
 public:
  explicit BoundedLog(std::size_t limit) : limit_(limit) {}

  void add(const T& entry) {
    if (size_ == limit_) {
      ++dropped_;
      return;
    }
    const std::size_t place = size_ % kChunk;
    if (place == 0) chunks_.push_back(std::make_unique_for_overwrite<T[]>(kChunk));
    chunks_.back()[place] = entry;
    ++size_;
  }
  std::size_t size() const { return size_; }
  std::uint64_t dropped() const { return dropped_; }

  /// All entries in the order in which they came.
  std::vector<T> copy() const {
    std::vector<T> all;
    all.reserve(size_);
    for (const auto& chunk : chunks_) {
      all.insert(all.end(), chunk.get(), chunk.get() + std::min(kChunk, size_ - all.size()));
    }
    return all;
  }

 private:
  static constexpr std::size_t kChunk = 1024;
  std::vector<std::unique_ptr<T[]>> chunks_;
  std::size_t limit_;
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
};

struct TraceOptions {
  bool spans = false;   ///< keep spans and departures, for a timeline; counters are always kept
  int most_ranks = 64;  ///< that keep them, evenly spread over those of the run: see keeps_spans()
  /// Of spans (40 bytes each), and as many departures (16 bytes each).
  std::size_t max_spans_per_lane = std::size_t{1} << 20;
};

/// Whether a rank of a run of so many keeps spans; rank 0 does. The others do not even record them: a lane
/// may have 60 MB, which would all go to rank 0.
constexpr bool keeps_spans(Rank rank, int ranks, const TraceOptions& options) {
  if (!options.spans || rank.value == 0 || ranks <= options.most_ranks) return options.spans;
  const auto spread = [&](std::int64_t r) { return r * options.most_ranks / ranks; };
  return spread(rank.value) > spread(rank.value - 1);
}

/// The record of one thread, or of a place that several take in turn. Written by one thread at a time,
/// without locks; read when the threads rest. What it writes shares no cache line with other lanes. Recording
/// throws only std::bad_alloc.
class alignas(64) Lane {
 public:
  Lane(int ranks, TraceOptions options);

  /// Counts the span, and keeps it if spans are kept. One that ends before it begins takes no time.
  void span(const Span& span);
  /// Nothing unless spans are kept.
  void departure(Departure departure);
  /// A message of method `name` (or kNoName) sent to, or received from, `peer`.
  void sent(Traffic traffic, std::uint32_t name, Rank peer, std::uint64_t bytes);
  void received(Traffic traffic, std::uint32_t name, Rank peer, std::uint64_t bytes);

  /// All spans of an activity.
  const TimeCount& time(Activity activity) const { return time_[static_cast<std::size_t>(activity)]; }
  /// Compute spans of method `name` (or kNoName).
  TimeCount compute_time(std::uint32_t name) const;
  const Volume& volume(Traffic traffic) const { return volume_[static_cast<std::size_t>(traffic)]; }
  Volume volume(std::uint32_t name) const;
  Volume volume(Rank peer) const;
  /// All that have messages, by rank.
  const PagedTable<Volume>& volumes_by_peer() const { return volume_by_peer_; }
  /// One more than the largest method index seen.
  std::uint32_t num_methods() const;
  const BoundedLog<Span>& spans() const { return spans_; }
  const BoundedLog<Departure>& departures() const { return departures_; }

 private:
  template <class T>
  using Table = std::vector<T, tbb::cache_aligned_allocator<T>>;
  void count_message(MessageCount Volume::*direction, Traffic traffic, std::uint32_t name, Rank peer,
                     std::uint64_t bytes);

  bool keeps_spans_;
  std::array<TimeCount, kActivities> time_{};
  std::array<Volume, kTraffics> volume_{};
  // By method, grown when one is seen first: place 0 is for what has no name, i + 1 for method i.
  Table<TimeCount> compute_by_method_;
  Table<Volume> volume_by_method_;
  PagedTable<Volume> volume_by_peer_;  // by rank; workers exchange none, and a rank few with most others
  BoundedLog<Span> spans_;
  BoundedLog<Departure> departures_;
};

/// The lanes of one rank: its communication thread's, one for each worker, and one for each slot of the arena
/// that a helper may take.
class Trace {
 public:
  /// `ranks`: of the run. `workers`, `helpers` >= 0.
  Trace(Rank rank, int ranks, int workers, TraceOptions options = {}, int helpers = 0);

  Rank rank() const { return rank_; }
  int ranks() const { return ranks_; }
  int workers() const { return workers_; }
  int helpers() const { return static_cast<int>(lanes_.size()) - 1 - workers_; }
  /// False: departures and causes need not be worked out.
  bool keeps_spans() const { return keeps_spans_; }

  Lane& communication_lane() { return lanes_.front(); }
  const Lane& communication_lane() const { return lanes_.front(); }
  /// The place of one of lanes().
  std::uint32_t index_of(const Lane& lane) const { return static_cast<std::uint32_t>(&lane - lanes_.data()); }
  /// `index`: 0 to workers() - 1.
  Lane& worker_lane(int index) { return lanes_[static_cast<std::size_t>(index) + 1]; }
  const Lane& worker_lane(int index) const { return lanes_[static_cast<std::size_t>(index) + 1]; }
  /// `slot`: 0 to helpers() - 1.
  Lane& helper_lane(int slot) { return lanes_[static_cast<std::size_t>(workers_ + slot) + 1]; }
  const Lane& helper_lane(int slot) const { return lanes_[static_cast<std::size_t>(workers_ + slot) + 1]; }
  /// The communication thread's, then the workers', then the helpers'.
  std::span<const Lane> lanes() const { return lanes_; }

 private:
  Rank rank_;
  int ranks_;
  int workers_;
  bool keeps_spans_;
  std::vector<Lane> lanes_;
};

}  // namespace weft::engine

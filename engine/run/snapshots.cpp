// The protocol of snapshots.
#include "engine/run/snapshots.h"

#include <algorithm>
#include <utility>

namespace weft::engine {

using Kind = SnapshotMessage::Kind;

Snapshots::Snapshots(SnapshotSink& sink, Scheduler& scheduler, Rank rank, int ranks, Post post)
    : sink_(sink), scheduler_(scheduler), rank_(rank), ranks_(ranks), post_(std::move(post)) {}

void Snapshots::begin_run() {
  scheduler_.end_snapshot();
  sink_.give_up();  // rank 0's also when its own part is stored, and another's was not in time
  stage_ = Stage::none;
  over_ = told_ready_ = wished_ = closing_ = false;
  not_stored_ = 0;
  not_ready_ = ranks_;
  objects_ = 0;
}

/// A snapshot that began when nothing was left to do would have objects copied while the program looks at
/// them.
void Snapshots::end_run() {
  over_ = true;
  scheduler_.end_snapshot();
}

void Snapshots::tell(Rank to, const SnapshotMessage& message) {
  if (to == rank_) return receive(rank_, message);
  post_(to, message);
}

void Snapshots::tell_all(const SnapshotMessage& message) {
  for (int r = 0; r < ranks_; ++r) tell(Rank(r), message);
}

/// A root sends without being copied itself, so there are no snapshots before all are through.
void Snapshots::step() {
  if (!told_ready_ && scheduler_.root_is_through()) {
    told_ready_ = true;
    tell(Rank(0), {.kind = Kind::ready, .objects = scheduler_.movable_objects_made()});
  }
  if (sink_.wanted()) tell(Rank(0), {.kind = Kind::wish});
  if (rank_.value == 0) begin_if_wanted();
  while (stage_ == Stage::collecting && tell_counts()) {  // rank 0's word to itself may ask for them again
  }
  if (stage_ == Stage::storing) tell_stored();
}

void Snapshots::begin_if_wanted() {
  if (!wished_ || not_ready_ > 0 || stage_ != Stage::none || not_stored_ > 0 || objects_ == 0) return;
  wished_ = settling_ = closing_ = false;
  counts_.assign(static_cast<std::size_t>(ranks_), {});
  rank_told_.assign(static_cast<std::size_t>(ranks_), Told::nothing);
  serials_.resize(static_cast<std::size_t>(ranks_), 0);
  tell_all({.kind = Kind::begin, .epoch = epoch_ + 1});
}

bool Snapshots::tell_counts() {
  const SnapshotCounts counts = scheduler_.snapshot_counts();
  if (told_ == counts) return false;
  told_ = counts;
  tell(Rank(0),
       {.kind = Kind::count, .good = settled_, .epoch = epoch_, .serial = ++last_serial_, .counts = counts});
  return true;
}

void Snapshots::tell_stored() {
  const std::optional<bool> stored = sink_.stored(epoch_);
  if (!stored) return;
  stage_ = Stage::none;
  tell(Rank(0), {.kind = Kind::stored, .good = *stored, .epoch = epoch_});
}

void Snapshots::receive(Rank from, const SnapshotMessage& message) {
  if (over_) return;
  switch (message.kind) {
    case Kind::ready:
      --not_ready_;
      objects_ += message.objects;
      return;
    case Kind::wish:  // the one that is being taken will do, as long as something may still be copied
      wished_ |= stage_ != Stage::collecting || settling_;
      return;
    case Kind::begin:
      epoch_ = message.epoch;
      stage_ = Stage::collecting;
      settled_ = false;
      told_.reset();
      return scheduler_.begin_snapshot(epoch_);
    case Kind::count:
      return note_counts(from, message);
    case Kind::settle:
      settled_ = true;
      return told_.reset();
    case Kind::close:
      scheduler_.end_snapshot();
      stage_ = Stage::storing;
      return sink_.close(epoch_);
    case Kind::stored:
      return note_stored(message);
  }
}

bool Snapshots::all_have_told(Told least) const {
  return std::all_of(rank_told_.begin(), rank_told_.end(), [&](Told told) { return told >= least; });
}

/// Once all objects have been copied, nobody sends anything more that belongs to the snapshot. Counts taken
/// before a rank knew of that may lack what an object sent there later, before it moved on and was copied
/// elsewhere. Those taken after it are final in what was sent; when as much has been received, all has come.
/// A rank that has told nothing may not have heard of the snapshot: the word that all have been copied is not
/// to overtake that it has begun.
void Snapshots::note_counts(Rank from, const SnapshotMessage& message) {
  if (message.epoch != epoch_ || closing_ || message.serial <= serials_[from.index()]) return;
  serials_[from.index()] = message.serial;
  counts_[from.index()] = message.counts;
  rank_told_[from.index()] = message.good ? Told::final_counts : Told::counts;
  SnapshotCounts sums;
  for (const SnapshotCounts& counts : counts_) {
    sums.copied += counts.copied;
    sums.sent += counts.sent;
    sums.received += counts.received;
  }
  if (sums.copied < objects_ || !all_have_told(Told::counts)) return;
  if (!settling_) {
    settling_ = true;
    return tell_all({.kind = Kind::settle, .epoch = epoch_});
  }
  if (sums.sent != sums.received || !all_have_told(Told::final_counts)) return;
  closing_ = true;
  not_stored_ = ranks_;
  all_good_ = true;
  tell_all({.kind = Kind::close, .epoch = epoch_});
}

void Snapshots::note_stored(const SnapshotMessage& message) {
  if (message.epoch != epoch_) return;
  all_good_ &= message.good;
  if (--not_stored_ == 0) sink_.finish(epoch_, all_good_);
}

}  // namespace weft::engine

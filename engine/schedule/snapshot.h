// A consistent state of all mobile objects of a run, taken while they work on.
//
// The colours of Lai and Yang (Inf. Proc. Letters 25, 1987), one an object: a snapshot has a number, its
// epoch; an object is copied before the first message that it handles after its rank has heard of the epoch,
// or after a message of an object that has been copied already has come here. Each message says which epoch
// its sender was in. So nothing that a copied object has sent is part of another object's copy, and what an
// object had sent before it was copied, and reaches another after that was, is kept beside the copies. All
// objects as they were copied, and these messages, are a state that the run could have been in: it can go on
// from there. Only an object that is being copied waits.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/base/serialize.h"

namespace weft::engine {

/// Where a rank's copies go. Of one epoch at a time; object() and message() are called by
/// any thread, the others by the communication thread.
class SnapshotSink {
 public:
  virtual ~SnapshotSink() = default;

  /// Several times a second: whether this rank wishes a snapshot now. Asked of
  /// every rank, and forgotten by it when it says so.
  virtual bool wanted() = 0;
  /// An object's copy, and a message that belongs to it, for Runtime::restore().
  virtual void object(std::uint64_t epoch, Payload copy) = 0;
  virtual void message(std::uint64_t epoch, Payload copy) = 0;
  /// All has come. To be stored for good, by another thread.
  virtual void close(std::uint64_t epoch) = 0;
  /// Whether it has been, once that is known.
  virtual std::optional<bool> stored(std::uint64_t epoch) = 0;
  /// On rank 0: all ranks have stored their parts (or one could not, `whole` is false then).
  virtual void finish(std::uint64_t epoch, bool whole) = 0;
  /// A run begins: what the one before has not finished, wishes too, never will be.
  virtual void give_up() = 0;
};

/// What a rank knows of the snapshot that is being taken.
struct SnapshotCounts {
  std::uint64_t copied = 0;    ///< objects, here
  std::uint64_t sent = 0;      ///< messages of objects that were not copied yet, to other ranks, ever
  std::uint64_t received = 0;  ///< of these, from other ranks
  friend bool operator==(const SnapshotCounts&, const SnapshotCounts&) = default;
};

}  // namespace weft::engine

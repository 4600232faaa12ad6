// Frames between ranks: many small ones in a packet, large ones uncopied, and never more than a receiver can
// take.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "engine/base/paged_table.h"
#include "engine/base/rank.h"
#include "engine/base/serialize.h"
#include "engine/network/load_table.h"
#include "engine/network/transport.h"

namespace weft::engine {

/// What a frame is for. Only tasks and objects are counted by the termination detector and held back for a
/// slow receiver; the others are the engine's own, few and small.
enum class FrameKind : std::uint8_t {
  task,       ///< a message to a mobile object
  object,     ///< a mobile object that moves
  location,   ///< where an object is now
  wave,       ///< termination
  balance,    ///< of the balancing policy
  stop,       ///< the run fails: stop
  broken,     ///< the same of a run in which the network fails or a rank dies: no other can follow
  failure,    ///< to rank 0: this rank has failed
  waits,      ///< to rank 0: who waits here for whom
  heartbeat,  ///< to the next rank: this rank lives, and is in this run
  leaving,    ///< to the next rank: and is in it no more
  bulletin,   ///< to the parent in the tree of ranks: how far this rank and those below it are
  notice,     ///< RuntimeOptions::notice has been set
  snapshot,   ///< of RuntimeOptions::snapshots
  clock,      ///< to the parent in the tree of ranks: what time is it at rank 0; and the answer
  report,     ///< to the parent: summaries and timelines, after the loop
};

struct ExchangeOptions {
  /// Bytes that may be on their way to, or wait unhandled at, one rank from one other. A larger message goes
  /// alone.
  std::size_t window_bytes = 16u << 20;
  /// The same from all others together: windows are smaller where there are many ranks. Beyond that, each
  /// rank may have one message of any size on its way.
  std::size_t inbox_bytes = 256u << 20;
  /// A handler that sends while more than this waits to be sent is held up until there is room, see post().
  std::size_t backlog_bytes = 64u << 20;
};

/// Sits between the engine and its transport. Back-pressure by credit: a sender has at most a window of bytes
/// under way to a rank, and gets them back when the receiver has *handled* them. What exceeds that waits at
/// the sender, whose handlers are held up when too much does.
class Exchange {
 public:
  using Receive = std::function<void(Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes)>;

  /// `program` is the same on all ranks whose messages mean the same (Registry::fingerprint()); another in a
  /// packet is an error, though what concerns the end of the run is still heard.
  Exchange(Transport& transport, ExchangeOptions options, std::uint64_t program = 0);

  /// Hands a frame over for sending, from any thread. Throws std::out_of_range when there is no such rank.
  void post(Rank to, FrameKind kind, Payload payload);

  /// Holds a worker up while more than backlog_bytes wait to be sent. It never waits while a message from
  /// another rank is unhandled here, so ranks cannot wait for each other: whoever is waited for has messages
  /// of the waiting rank unhandled (else it would have told), and goes on. Returns at once after
  /// release_waiters().
  void wait_for_room();
  void release_waiters();

  /// The receiver is done with `wire_bytes` of a task or object from `from`. Any thread.
  void consumed(Rank from, std::size_t wire_bytes);

  /// The rest is for the communication thread only.

  /// Starts the next run of the engine's loop: frames of earlier runs are dropped, of later ones kept until
  /// then. Ranks leave a run one by one, before it is over for all: a failure in it is heard by those who
  /// have left, and what they tell of it by those who are in it; and whether a rank lives.
  void begin_phase();

  /// This rank has failed and will not come to a later run: it hears at once how one has failed there, for
  /// who has decided that is in no run any more.
  void hear_later_failures();
  /// Whether it has.
  bool later_phase_failed() const { return later_phase_failed_; }

  /// Sends and receives what can be; true when anything happened.
  bool progress(const Receive& receive);

  /// All that was posted has been sent, as far as this rank is concerned.
  bool idle();
  /// The same for the engine's own frames only: those of a run that fails need not get out.
  bool urgent_idle();

  /// This rank's load, told to every rank that gets a packet anyway; and what was heard from others so (-1:
  /// nothing yet).
  void set_load(double seconds) { load_ = seconds; }
  double load_of(Rank rank) const { return loads_.of(rank); }
  /// Of the other ranks heard from the one with the greatest load above 0, the first of equal ones.
  Rank most_loaded() const { return loads_.most_loaded(); }

  std::uint64_t packets_sent() const { return packets_sent_; }

  /// What is on its way, in bytes of tasks and objects.
  struct Traffic {
    std::uint64_t unsent = 0;     ///< posted here, not yet sent
    std::uint64_t unhandled = 0;  ///< received here, not yet handled
    std::vector<std::pair<Rank, std::uint64_t>>
        unconfirmed;  ///< sent, and for all that is known not handled there
  };
  Traffic traffic() const;

 private:
  struct Frame {
    FrameKind kind;
    Payload payload;
    std::size_t wire_bytes;
  };
  struct Posted {
    Rank to;
    Frame frame;
  };
  /// Takes memory for the frames that are in it alone: each rank has two for every other that it talks to.
  using Queue = std::list<Frame>;
  /// Made when the first packet to or from the rank comes: most ranks talk to few others.
  struct Peer {
    bool pending = false;         ///< in pending_peers_
    Queue urgent;                 ///< uncounted frames: they pass what is held back
    Queue waiting;                ///< counted frames
    std::uint64_t under_way = 0;  ///< counted bytes sent and not yet consumed
  };

  bool take_posted();
  bool flush(Rank to, Peer& peer);
  bool may_send(const Peer& peer) const;
  void send_packet(Rank to, Peer& peer, std::uint64_t credit);
  void append(Packet& packet, Frame frame);
  void unpack(Rank from, std::span<const std::byte> head, std::vector<Blob> segments, const Receive& receive);
  void deliver(Rank from, Frame frame, const Receive& receive);

  Transport& transport_;
  std::size_t window_;         ///< of each peer
  std::size_t backlog_bytes_;  ///< ExchangeOptions
  std::uint64_t program_;
  Peer& peer_of(Rank rank);
  PagedTable<std::unique_ptr<Peer>> peers_;
  std::vector<Rank> pending_peers_;  ///< those with frames, each once
  PagedCounters credits_;            ///< by rank: consumed and not yet told
  LoadTable loads_;
  std::atomic<bool> credits_due_{false};

  std::mutex mutex_;
  std::condition_variable room_;
  std::vector<Posted> posted_;
  std::vector<Posted> taken_;
  bool released_ = false;

  std::atomic<std::size_t> backlog_{0};  ///< counted bytes posted and not yet sent
  std::atomic<std::int64_t> inbox_{0};   ///< counted bytes received and not yet consumed
  std::uint64_t first_phase_ = 0;
  std::uint64_t phase_ = 0;
  std::uint64_t failed_phase_ = 0;  ///< the first that this rank had left when another failed in it; 0: none
  bool hears_later_failures_ = false;
  bool later_phase_failed_ = false;
  bool look_at_kept_ = false;
  double load_ = 0;
  std::uint64_t packets_sent_ = 0;
};

}  // namespace weft::engine

// The network as the engine sees it: packets from rank to rank, nothing else.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/blob.h"
#include "engine/base/rank.h"
#include "engine/base/virtual_time.h"

namespace weft::engine {

/// What travels: a small head, copied, and any number of large segments, which are not.
struct Packet {
  std::vector<std::byte> head;  ///< at most Transport::kMaxHead bytes
  std::vector<Blob> segments;   ///< each of any size, 0 included
};

/// A packet that came before its time, see Transport::keep().
struct KeptPacket {
  Rank from;
  std::vector<std::byte> head;
  std::vector<Blob> segments;
};

/// A rank for which the others would wait in vain.
struct LostPeer {
  Rank rank;
  std::string how;          ///< what follows the words "rank 3"
  bool will_close = false;  ///< it has left and comes to close(); else close() would wait for ever
};

/// What a rank tells the others when it goes: see Transport::leave() and abandon().
struct LeaveNotice {
  Rank rank;
  std::uint64_t ended_phase = 0;  ///< the last in which it took part until the end
  std::string why;
  bool will_close = false;
};

/// The network broke, or was misused; the run cannot go on.
class TransportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Point-to-point packets between the ranks of a run. Every packet sent arrives once, whole; in *any order*:
/// nothing above may count on one (that keeps large packets from holding up small ones, and tests shuffle
/// them).
///
/// All functions but wake() are called by one thread, the rank's communication thread; it gets nowhere unless
/// poll() is called.
class Transport {
 public:
  static constexpr std::size_t kMaxHead = 64 * 1024;
  static constexpr std::uint64_t kPhasesOfAUser = std::uint64_t{1} << 32;

  /// Called for each packet that has arrived. The head is gone when it returns, the segments are the
  /// receiver's. It may call send() but not poll().
  using Receive = std::function<void(Rank from, std::span<const std::byte> head, std::vector<Blob> segments)>;

  virtual ~Transport() = default;

  virtual Rank rank() const = 0;
  virtual int size() const = 0;

  /// Takes the packet and returns at once. `to` may be this rank. Throws TransportError (head too long, no
  /// such rank).
  virtual void send(Rank to, Packet packet) = 0;

  /// Moves everything on that can be moved, and calls `receive` for what has arrived; true when anything
  /// happened.
  virtual bool poll(const Receive& receive) = 0;

  /// Packets to `to` that the network has not taken over yet. The layer above lets small ones pile up behind
  /// them and sends them as one.
  virtual std::size_t unsent(Rank to) const = 0;
  /// Whether there are none to any rank.
  virtual bool all_sent() const {
    for (int r = 0; r < size(); ++r)
      if (unsent(Rank(r)) > 0) return false;
    return true;
  }

  /// The clock of a simulated rank, whose handlers run when this is asked for time; null: the rank is real,
  /// and has workers.
  virtual VirtualTime* virtual_time() { return nullptr; }

  /// Sleeps until a packet may have arrived, wake() is called (also just before: it is remembered), or
  /// `at_most` is over. Uses no processor time to speak of. May return early for no reason.
  virtual void wait(std::chrono::nanoseconds at_most) = 0;

  /// Ends wait(). From any thread or signal handler.
  virtual void wake() noexcept = 0;

  /// A rank that will not take part in the current phase (see next_phase()): its process is gone though it
  /// did not call close(), or it has abandoned the network, or it has left after an earlier phase. Cheap
  /// enough to ask a few times a second.
  virtual std::optional<LostPeer> lost_peer() = 0;

  /// True when the end of that rank's process is seen by lost_peer(): its silence means nothing then.
  virtual bool watches(Rank) const { return false; }

  /// Tells all others that this rank takes part in no phase any more, but will call close(). `why` follows
  /// the words "rank 3" in what they report.
  virtual void leave(const std::string& why) noexcept = 0;

  /// The last act of all ranks, in whatever state each is: what has been sent and not yet been received is
  /// received and dropped, so that nobody is left with half a message; then the network is shut down. All
  /// ranks must call it, and it waits for them, however long they take to come. Throws TransportError when a
  /// rank is known to be dead or to have abandoned the network; then abandon() remains. May use collective
  /// calls: the run is over.
  virtual void close() = 0;

  /// Gives up on the network without waiting for anybody; allowed when a peer has died. Whether it ends the
  /// process is said by each transport; if not, all later use but wake() throws TransportError.
  virtual void abandon() noexcept = 0;
  virtual bool abandoning_ends_process() const { return false; }

  /// Network calls made so far by this process, by name ("MPI_Isend"), for reports and for the test that none
  /// of the loop's is collective; empty when the transport has none to count.
  virtual std::vector<std::pair<std::string, long>> calls() const { return {}; }

  /// Numbers the phases in which the ranks use the network one after the other, alike on all ranks. A rank
  /// may be some phases ahead of another: what it sends is kept here, beyond the life of whoever uses the
  /// network now. Only a transport that passes everything on to another overrides these.
  virtual std::uint64_t next_phase() { return ++phase_; }
  /// The first of whoever uses the network next, beyond all of whoever does now: where one has failed, not
  /// all ranks have come equally far. Of one user the numbers differ by less than kPhasesOfAUser.
  virtual std::uint64_t first_phase() { return phase_ = (phase_ / kPhasesOfAUser + 1) * kPhasesOfAUser; }
  /// The current phase is over for this rank, in good order.
  virtual void end_phase() { ended_phase_ = phase_; }
  virtual void keep(KeptPacket packet) { kept_.push_back(std::move(packet)); }
  virtual std::vector<KeptPacket> take_kept() { return std::exchange(kept_, {}); }

 protected:
  std::uint64_t phase() const { return phase_; }
  std::uint64_t ended_phase() const { return ended_phase_; }

  /// The first of those ranks that the phase waits for in vain.
  static std::optional<LostPeer> missed_in(std::uint64_t phase, std::span<const LeaveNotice> notices) {
    for (const LeaveNotice& notice : notices) {
      if (notice.will_close && notice.ended_phase >= phase) continue;
      return LostPeer{notice.rank, notice.why, notice.will_close};
    }
    return std::nullopt;
  }

 private:
  std::uint64_t phase_ = 0;
  std::uint64_t ended_phase_ = 0;
  std::vector<KeptPacket> kept_;
};

}  // namespace weft::engine

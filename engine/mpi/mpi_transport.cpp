// Heads go through a ring of receives posted in advance; segments follow as messages of their own, sent from
// and received into their blobs.
#include "engine/mpi/mpi_transport.h"

#include <mpi.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <climits>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <limits>
#include <string>
#include <system_error>
#include <thread>

#include "engine/mpi/ancestry.h"
#include "engine/mpi/mpi_calls.h"
#include "engine/mpi/node_table.h"

namespace weft::engine {
namespace {

using namespace std::chrono_literals;
using Sizes = std::vector<std::uint64_t>;

/// On a communicator of their own, since they are received with any tag: a head that is all of its packet, or
/// one with more to say about what follows (see Trailer). The former goes as it is, without being copied.
constexpr int kLoneHeadTag = 0;
constexpr int kHeadTag = 1;
/// The sender goes, see LeaveNotice: the number of its last phase, and why.
constexpr int kLeaveTag = 2;
constexpr int kAbandonTag = 3;
constexpr std::size_t kHeadReceives = 16;
/// So many sizes of segments travel behind the head; more go as a message of their own, before the segments.
constexpr std::size_t kInlineSizes = 64;
/// Requests tested at a time: a poll stays short however many are under way.
constexpr std::size_t kTested = 64;

/// With all peers on this node every event rings, and waking up now and then is a safety net only.
constexpr std::chrono::nanoseconds kLongestSleep = 50ms;
/// No bell rings for peers on other nodes.
constexpr std::chrono::nanoseconds kLongestRemoteSleep = 500us;
constexpr std::chrono::nanoseconds kShortestSleep = 20us;
/// With so many sends under way, parts of packets wait (heads do not): Open MPI goes through all sends that
/// lack buffers at every call, which would be quadratic in their number.
constexpr std::size_t kMostPosted = 256;
/// Up to this long, an MPI takes a message over at once, as a rule.
constexpr std::size_t kShortHead = 4096;
/// So often wait() only yields while messages are under way.
constexpr int kYields = 16;
/// Polls for what has rung: the parts of a long head may take several (Open MPI without single copy).
constexpr int kLooks = 2;
constexpr std::chrono::nanoseconds kDeathWatch = 1s;

/// The end of a kHeadTag message, which is the head, the sizes of the segments unless there are too many, and
/// this.
struct Trailer {
  std::uint32_t segments;
  std::int32_t tag;  ///< of the messages with the segments
};
constexpr std::size_t kHeadBuffer =
    Transport::kMaxHead + kInlineSizes * sizeof(std::uint64_t) + sizeof(Trailer);

std::string text_of(int error) {
  std::array<char, MPI_MAX_ERROR_STRING + 1> text{};
  int length = 0;
  if (MPI_Error_string(error, text.data(), &length) != MPI_SUCCESS) return "error " + std::to_string(error);
  return text.data();
}

void check(int error, const char* function) {
  if (error != MPI_SUCCESS) throw TransportError(std::string(function) + " failed: " + text_of(error));
}

template <class T>
void append(std::vector<std::byte>& bytes, const T* values, std::size_t count) {
  const auto* first = reinterpret_cast<const std::byte*>(values);
  bytes.insert(bytes.end(), first, first + count * sizeof(T));
}

/// A packet on its way out: what MPI reads from until all its messages are sent.
struct Outgoing {
  Outgoing(Rank rank, Packet content) : to(rank), packet(std::move(content)) {}

  Rank to;
  Packet packet;
  Sizes sizes;           ///< when they are a message of their own
  std::size_t open = 0;  ///< messages that are not through
};

/// A part of a packet that MPI has not been given yet.
struct Message {
  std::shared_ptr<Outgoing> out;
  const std::byte* data;
  int size;
  int tag;
};

/// A packet with segments whose head has arrived.
struct Incoming {
  Rank from;
  std::int32_t tag = 0;
  std::vector<std::byte> head;
  Sizes sizes;
  std::vector<Blob> segments;
  bool sizes_known = false;
  std::size_t open = 0;
};

/// Requests under way, each of some packet.
template <class Owner>
class Requests {
 public:
  /// A test finishes no more than that: it needs no memory.
  Requests() {
    finished_.reserve(kTested);
    told_.reserve(kTested);
  }

  bool empty() const { return requests_.empty(); }
  std::size_t size() const { return requests_.size(); }

  /// A place for the request of a message of `owner`, which has counted it in `open`. All or nothing: what
  /// throws for want of memory, throws before MPI is given the message.
  MPI_Request* add(std::shared_ptr<Owner> owner) {
    make_room();
    owners_.push_back(std::move(owner));
    return &requests_.emplace_back(MPI_REQUEST_NULL);
  }

  /// Undoes the last add(), whose message is through.
  std::shared_ptr<Owner> take_last() {
    std::shared_ptr<Owner> owner = std::move(owners_.back());
    owners_.pop_back();
    requests_.pop_back();
    return owner;
  }

  /// Calls done(owner) for each owner whose last message is through; true when any message is.
  template <class Done>
  bool test(const Done& done) {
    if (requests_.empty()) return false;
    if (next_ >= requests_.size()) next_ = 0;
    const std::size_t first = next_;
    const std::size_t tested = std::min(kTested, requests_.size() - first);
    int count = 0;
    std::array<int, kTested> which;
    std::array<MPI_Status, kTested> statuses;
    const int error =
        MPI_Testsome(static_cast<int>(tested), &requests_[first], &count, which.data(), statuses.data());
    if (error == MPI_ERR_IN_STATUS) {
      for (int i = 0; i < count; ++i) check(statuses[static_cast<std::size_t>(i)].MPI_ERROR, "MPI_Testsome");
    }
    check(error, "MPI_Testsome");
    next_ = first + tested;
    if (count <= 0) return false;  // 0, or MPI_UNDEFINED
    remove_done(first, tested);
    // Taken out before anything is told: `done` may add requests.
    told_.swap(finished_);
    for (auto& owner : told_) done(owner);
    told_.clear();
    return true;
  }

 private:
  void make_room() {
    if (size() < std::min(requests_.capacity(), owners_.capacity())) return;
    const std::size_t room = std::max(kTested, 2 * size());
    requests_.reserve(room);
    owners_.reserve(room);
  }

  void remove_done(std::size_t first, std::size_t tested) {
    for (std::size_t i = first + tested; i-- > first;) {
      if (requests_[i] != MPI_REQUEST_NULL) continue;
      if (--owners_[i]->open == 0) finished_.push_back(std::move(owners_[i]));
      requests_[i] = requests_.back();
      requests_.pop_back();
      if (i + 1 != owners_.size()) owners_[i] = std::move(owners_.back());
      owners_.pop_back();
    }
  }

  std::vector<MPI_Request> requests_;
  std::vector<std::shared_ptr<Owner>> owners_;
  std::vector<std::shared_ptr<Owner>> finished_, told_;
  std::size_t next_ = 0;  ///< where the next test begins
};

void start_mpi(int* argc, char*** argv) {
  int initialized = 0, finalized = 0;
  check(MPI_Initialized(&initialized), "MPI_Initialized");
  check(MPI_Finalized(&finalized), "MPI_Finalized");
  if (finalized)
    throw TransportError(
        "MPI has been ended, by an earlier call (on files, say) that had started it or by the program, and "
        "starts only once in a process: for several such calls start it before the first (MPI_Init, or "
        "import mpi4py.MPI) and end it after the last");
  if (initialized) {
    throw TransportError(
        "MPI has been initialised already; then an MpiTransport is made on a communicator of the program");
  }
  int provided = 0;
  check(MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
  if (provided < MPI_THREAD_FUNNELED)
    throw TransportError("this MPI cannot be used in programs with threads");
  // Before the first call that can fail: errors are reported, not fatal.
  check(MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
}

/// Of MPI's start to the first message that every rank has had.
constexpr std::chrono::seconds kLongestStart{60};

/// Returns when all ranks have called it. `at_most`: throws TransportError after so long.
MPI_Comm duplicate(MPI_Comm original, std::chrono::nanoseconds at_most) {
  const auto begin = std::chrono::steady_clock::now();
  MPI_Comm communicator = MPI_COMM_NULL;
  MPI_Request request = MPI_REQUEST_NULL;
  check(MPI_Comm_idup(original, &communicator, &request), "MPI_Comm_idup");
  for (int done = 0;;) {
    check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
    if (done) break;
    if (std::chrono::steady_clock::now() - begin > at_most)
      throw TransportError("the ranks have not reached each other within " +
                           std::to_string(kLongestStart.count()) + " seconds of MPI's start");
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
  check(MPI_Comm_set_errhandler(communicator, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  return communicator;
}

/// The program's own ranks come from MPI_Init at one time; where MPI has found no way between two of them,
/// which it need not tell (Open MPI 4.1 waits for ever), nobody must wait. A caller's ranks come when they
/// like.
std::chrono::nanoseconds longest_start(bool own_mpi) {
  return own_mpi ? std::chrono::nanoseconds(kLongestStart) : std::chrono::nanoseconds::max();
}

/// What can be seen to be wrong with the caller's use of MPI before anything collective.
MPI_Comm checked(CallersCommunicator callers) {
  if (!mpi_is_running()) throw TransportError("MPI is not running: the caller initialises it");
  if (callers.mpi_comm == nullptr) throw TransportError("there is no communicator at a null address");
  const MPI_Comm communicator = *static_cast<const MPI_Comm*>(callers.mpi_comm);
  if (communicator == MPI_COMM_NULL) throw TransportError("the communicator is MPI_COMM_NULL");
  int provided = 0, is_main = 0, is_inter = 0;
  check(MPI_Query_thread(&provided), "MPI_Query_thread");
  check(MPI_Is_thread_main(&is_main), "MPI_Is_thread_main");
  if (provided < MPI_THREAD_SERIALIZED && !is_main)
    throw TransportError("MPI was initialised for calls from its main thread only, which this is not");
  check(MPI_Comm_test_inter(communicator, &is_inter), "MPI_Comm_test_inter");
  if (is_inter) throw TransportError("the communicator is an intercommunicator");
  return communicator;
}

/// The ranks of this node, and the table they share.
class Node {
 public:
  Node(MPI_Comm world, bool share) : share_(share) {
    int rank = 0, size = 0;
    check(MPI_Comm_rank(world, &rank), "MPI_Comm_rank");
    check(MPI_Comm_size(world, &size), "MPI_Comm_size");
    lines_.resize(static_cast<std::size_t>(size));
    MPI_Comm local = MPI_COMM_NULL;
    check(MPI_Comm_split_type(world, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &local),
          "MPI_Comm_split_type");
    check(MPI_Comm_set_errhandler(local, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    share_table(local, rank);
    check(MPI_Comm_free(&local), "MPI_Comm_free");
  }

  NodePlace& own() const { return table_[own_line_]; }
  bool has_all() const { return ranks_.size() == lines_.size(); }

  void ring(Rank rank) const {
    if (NodePlace* place = lines_[rank.index()]) place->bell.ring();
  }

  void ring_all() const {
    for (const Rank rank : ranks_) ring(rank);
  }

  bool watches(Rank rank) const {
    const NodePlace* place = lines_[rank.index()];
    return place && table_.watches(static_cast<std::size_t>(place - &table_[0]));
  }

  std::optional<Rank> dead() const {
    const auto line = table_.dead();
    return line ? std::optional(ranks_[*line]) : std::nullopt;
  }

 private:
  /// Ranks whose processes cannot share memory, though MPI says they are on one node (containers), are
  /// treated as if on different nodes.
  void share_table(MPI_Comm local, int rank) {
    int line = 0, size = 0;
    check(MPI_Comm_rank(local, &line), "MPI_Comm_rank");
    check(MPI_Comm_size(local, &size), "MPI_Comm_size");
    std::vector<int> ranks(static_cast<std::size_t>(size));
    check(MPI_Allgather(&rank, 1, MPI_INT, ranks.data(), 1, MPI_INT, local), "MPI_Allgather");
    if (share_ && size > 1 && attach_table(local, line, ranks.size())) {
      own_line_ = static_cast<std::size_t>(line);
      for (const int each : ranks) ranks_.emplace_back(each);
    } else {
      ranks_.emplace_back(rank);
    }
    table_.enter(own_line_);
    for (std::size_t i = 0; i < ranks_.size(); ++i) lines_[ranks_[i].index()] = &table_[i];
    check(MPI_Barrier(local), "MPI_Barrier");
    table_.watch(own_line_);  // all live: none gets through close() before all are out of here
  }

  /// True, everywhere, when all have it.
  bool attach_table(MPI_Comm local, int line, std::size_t lines) {
    std::array<char, 64> name{};
    bool created = false;
    if (line == 0) created = create_table(lines, name);
    check(MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0, local), "MPI_Bcast");
    const int mine = line == 0 ? created : name[0] != '\0' && attach(lines, name.data());
    int all = 0;
    check(MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MIN, local), "MPI_Allreduce");
    if (created) NodeTable::unlink(name.data());
    if (!all) table_ = NodeTable();
    return all != 0;
  }

  /// Leaves `name` empty when it cannot.
  bool create_table(std::size_t lines, std::array<char, 64>& name) {
    static std::atomic<unsigned> tables{0};  // a process may have several transports at once
    const auto text = "/weft-" + std::to_string(getpid()) + "-" + std::to_string(tables++) + "-" +
                      std::to_string(std::chrono::system_clock::now().time_since_epoch().count());
    try {
      table_ = NodeTable::create(lines, text);
    } catch (const std::system_error&) {
      return false;
    }
    std::ranges::copy(text, name.begin());
    return true;
  }

  bool attach(std::size_t lines, const char* name) {
    try {
      table_ = NodeTable::attach(lines, name);
      return true;
    } catch (const std::system_error&) {
      return false;
    }
  }

  bool share_;
  NodeTable table_;
  std::size_t own_line_ = 0;
  std::vector<Rank> ranks_;        ///< by line
  std::vector<NodePlace*> lines_;  ///< by rank; null on other nodes
};

}  // namespace

class MpiTransport::Impl {
 public:
  /// Whose MPI it is.
  enum class Mpi { own, callers };

  Impl(MPI_Comm communicator, Mpi mpi, MpiTransportOptions options);

  Rank rank() const { return rank_; }
  int size() const { return static_cast<int>(sent_.size()); }
  std::size_t unsent(Rank to) const { return unsent_.at(to.index()); }

  void send(Rank to, Packet packet);
  bool poll(const Receive& receive);
  void wait(std::chrono::nanoseconds at_most);
  void wake() noexcept { node_.own().bell.ring(); }
  std::optional<Rank> dead() const { return node_.dead(); }
  bool watches(Rank rank) const { return node_.watches(rank); }
  const std::vector<LeaveNotice>& notices() const { return notices_; }
  void leave(std::uint64_t ended_phase, const std::string& why) noexcept {
    depart(kLeaveTag, ended_phase, why);
  }
  void close();
  void abandon(std::uint64_t ended_phase) noexcept;
  bool abandoned() const { return state_ == State::kAbandoned; }
  bool owns_mpi() const { return mpi_ == Mpi::own; }

  /// MPI may still read and write its buffers, so it is never destroyed; leak checkers see it in a list.
  static void leave_behind(std::unique_ptr<Impl> impl) noexcept {
    static std::atomic<Impl*> last{nullptr};
    impl->left_before_ = last;
    while (!last.compare_exchange_weak(impl->left_before_, impl.get())) {
    }
    static_cast<void>(impl.release());  // in the list now
  }

 private:
  enum class State { kOpen, kClosing, kClosed, kAbandoned };

  /// One of the receives posted in advance.
  struct HeadReceive {
    std::vector<std::byte> buffer;
    MPI_Request request = MPI_REQUEST_NULL;
    bool posted = false;
  };
  /// A packet that has arrived in full.
  struct Arrived {
    Rank from;
    std::vector<std::byte> head;
    std::vector<Blob> segments;
  };

  void post_heads();
  void post(HeadReceive& slot);

  void check_usable() const;
  void depart(int tag, std::uint64_t ended_phase, const std::string& why) noexcept;
  template <class Step>
  void or_break(const char* what, Rank peer, const Step& step);
  void send_lone_head(Rank to, int tag, Packet packet);
  void send_all(Rank to, Packet packet);
  void queue_bytes(const std::shared_ptr<Outgoing>& out, const void* data, std::size_t size, int tag);
  void post_queued();
  std::int32_t next_tag(Rank to);

  bool receive_heads(const Receive& receive);
  void take_head(Rank from, int tag, std::span<const std::byte> message, const Receive& receive);
  void note_leaving(Rank from, int tag, std::span<const std::byte> message);
  void expect_segments(Rank from, std::span<const std::byte> message);
  void post_segments(const std::shared_ptr<Incoming>& in);
  void receive_bytes(const std::shared_ptr<Incoming>& in, void* data, std::size_t size);
  void take_finished(const std::shared_ptr<Incoming>& in);
  bool deliver(const Receive& receive);

  std::chrono::nanoseconds longest_sleep();
  void finish(MPI_Request request);
  void drop();
  void check_deaths();
  void cancel_heads();

  Impl* left_before_ = nullptr;
  std::string broken_;  ///< why nothing can be sent or received any more
  Mpi mpi_;
  MPI_Comm head_comm_;
  MPI_Comm segment_comm_;
  std::size_t chunk_;
  Node node_;
  Rank rank_;
  std::int64_t tags_ = 0;  ///< how many there are for segments
  State state_ = State::kOpen;

  std::array<HeadReceive, kHeadReceives> heads_;
  std::size_t head_ = 0;  ///< the one posted longest ago, which completes first
  Requests<Outgoing> sends_;
  std::shared_ptr<Outgoing> spare_;  ///< of the last lone head that was through at once
  std::deque<Message> queued_;
  Requests<Incoming> receives_;
  std::deque<Arrived> arrived_;

  /// Packets by rank: those whose head MPI has been given, and whole ones. close() compares them.
  std::vector<std::uint64_t> sent_, received_;
  std::vector<std::uint64_t>
      expected_;  ///< what others have sent here; MPI may write it after close() has thrown
  std::vector<std::size_t> unsent_;
  std::vector<std::int64_t> tagged_;  ///< packets with segments, by rank
  std::vector<LeaveNotice> notices_;

  Sleeper::Ticket seen_ = 0;
  int quiet_ = 0;  ///< waits since anything happened
  int looks_ = 0;  ///< that are left, of kLooks
  std::chrono::steady_clock::time_point next_death_watch_;
};

MpiTransport::Impl::Impl(MPI_Comm communicator, Mpi mpi, MpiTransportOptions options)
    : mpi_(mpi),
      head_comm_(duplicate(communicator, longest_start(mpi == Mpi::own))),
      segment_comm_(duplicate(communicator, longest_start(mpi == Mpi::own))),
      chunk_(options.chunk_bytes),
      node_(head_comm_, options.shared_memory) {
  if (chunk_ < 1 || chunk_ > INT_MAX) throw TransportError("chunk_bytes must be 1 to 2147483647");
  int rank = 0, size = 0;
  check(MPI_Comm_rank(head_comm_, &rank), "MPI_Comm_rank");
  check(MPI_Comm_size(head_comm_, &size), "MPI_Comm_size");
  rank_ = Rank(rank);
  for (auto* counts : {&sent_, &received_}) counts->resize(static_cast<std::size_t>(size));
  unsent_.resize(sent_.size());
  tagged_.resize(sent_.size());
  const int* most = nullptr;
  int given = 0;
  check(MPI_Comm_get_attr(MPI_COMM_WORLD, MPI_TAG_UB, static_cast<void*>(&most), &given),
        "MPI_Comm_get_attr");
  tags_ = (given ? std::int64_t{*most} : 32767) + 1;  // 32767 is what every MPI has
  post_heads();
}

void MpiTransport::Impl::post_heads() {
  for (HeadReceive& slot : heads_) {
    slot.buffer.resize(kHeadBuffer);
    check(MPI_Recv_init(slot.buffer.data(), static_cast<int>(kHeadBuffer), MPI_BYTE, MPI_ANY_SOURCE,
                        MPI_ANY_TAG, head_comm_, &slot.request),
          "MPI_Recv_init");
    post(slot);
  }
}

void MpiTransport::Impl::post(HeadReceive& slot) {
  check(MPI_Start(&slot.request), "MPI_Start");
  slot.posted = true;
}

// ---- sending

void MpiTransport::Impl::send(Rank to, Packet packet) {
  check_usable();
  if (state_ != State::kOpen) throw TransportError("nothing can be sent any more: the network is closed");
  if (!to.valid() || to.value >= size()) {
    throw TransportError("there is no rank " + std::to_string(to.value) + " among " + std::to_string(size()));
  }
  if (packet.head.size() > kMaxHead) {
    throw TransportError("a head of " + std::to_string(packet.head.size()) + " bytes is longer than the " +
                         std::to_string(kMaxHead) + " allowed");
  }
  if (packet.segments.size() > std::numeric_limits<std::uint32_t>::max())
    throw TransportError("too many segments");
  if (to == rank_) {
    arrived_.push_back({rank_, std::move(packet.head), std::move(packet.segments)});
    return;
  }
  or_break("sent to", to, [&] {
    if (packet.segments.empty()) {
      send_lone_head(to, kLoneHeadTag, std::move(packet));
    } else {
      send_all(to, std::move(packet));
    }
  });
  node_.ring(to);
}

/// A step that fails (memory is short) leaves messages on their way that nothing will ever receive or send,
/// and may leave a packet that must not be taken for whole: that is the end of this network.
template <class Step>
void MpiTransport::Impl::or_break(const char* what, Rank peer, const Step& step) {
  try {
    step();
  } catch (const std::exception& error) {
    broken_ = "out of memory";  // which takes none, as the reason may
    broken_ = std::string("a packet cannot be ") + what + " rank " + std::to_string(peer.value) + ": " +
              error.what();
    throw TransportError(broken_);
  }
}

/// All memory is there before MPI reads from any: what it reads from is kept whatever fails. Most packets are
/// a short head only, which MPI takes over at once: they take none, since the next one uses their Outgoing.
void MpiTransport::Impl::send_lone_head(Rank to, int tag, Packet packet) {
  auto out = spare_ ? std::move(spare_) : std::make_shared<Outgoing>(to, Packet());
  out->to = to;
  out->packet = std::move(packet);
  out->open = 1;
  const std::vector<std::byte>& head = out->packet.head;
  MPI_Request* const request = sends_.add(std::move(out));
  ++unsent_[to.index()];
  check(MPI_Isend(head.data(), static_cast<int>(head.size()), MPI_BYTE, to.value, tag, head_comm_, request),
        "MPI_Isend");
  ++sent_[to.index()];
  int through = 0;
  if (head.size() <= kShortHead) check(MPI_Test(request, &through, MPI_STATUS_IGNORE), "MPI_Test");
  if (!through) return;
  spare_ = sends_.take_last();
  --unsent_[to.index()];
}

/// Best effort: a rank that cannot be told finds out in another way, or never.
void MpiTransport::Impl::depart(int tag, std::uint64_t ended_phase, const std::string& why) noexcept {
  if (state_ == State::kClosed || state_ == State::kAbandoned) return;
  try {
    for (int r = 0; r < size(); ++r) {
      if (r == rank_.value) continue;
      Packet packet;
      append(packet.head, &ended_phase, 1);
      append(packet.head, why.data(), std::min(why.size(), kShortHead - sizeof ended_phase));
      send_lone_head(Rank(r), tag, std::move(packet));
      node_.ring(Rank(r));
    }
  } catch (const std::exception&) {
  }
}

/// What follows the head is queued before that goes: a head announces nothing that does not come.
void MpiTransport::Impl::send_all(Rank to, Packet packet) {
  const Trailer trailer{static_cast<std::uint32_t>(packet.segments.size()), next_tag(to)};
  Sizes sizes;
  for (const Blob& segment : packet.segments) sizes.push_back(segment.size());
  const auto out = std::make_shared<Outgoing>(to, std::move(packet));
  auto& head = out->packet.head;
  const bool fits = sizes.size() <= kInlineSizes;
  if (fits) append(head, sizes.data(), sizes.size());
  append(head, &trailer, 1);
  if (!fits) {
    out->sizes = std::move(sizes);
    queue_bytes(out, out->sizes.data(), out->sizes.size() * sizeof(Sizes::value_type), trailer.tag);
  }
  for (const Blob& segment : out->packet.segments) {
    queue_bytes(out, segment.data(), segment.size(), trailer.tag);
  }
  ++out->open;
  MPI_Request* const request = sends_.add(out);
  ++unsent_[to.index()];
  check(MPI_Isend(head.data(), static_cast<int>(head.size()), MPI_BYTE, to.value, kHeadTag, head_comm_,
                  request),
        "MPI_Isend");
  ++sent_[to.index()];
  post_queued();
}

/// 0 bytes are no message.
void MpiTransport::Impl::queue_bytes(const std::shared_ptr<Outgoing>& out, const void* data, std::size_t size,
                                     int tag) {
  for (std::size_t done = 0; done < size; done += chunk_) {
    const auto count = static_cast<int>(std::min(chunk_, size - done));
    queued_.push_back({out, static_cast<const std::byte*>(data) + done, count, tag});
    ++out->open;
  }
}

/// Whenever anything is queued, kMostPosted messages are under way after this: what is sent draws the rest
/// along.
void MpiTransport::Impl::post_queued() {
  for (; !queued_.empty() && sends_.size() < kMostPosted; queued_.pop_front()) {
    const Message& message = queued_.front();
    const Rank to = message.out->to;
    check(MPI_Isend(message.data, message.size, MPI_BYTE, to.value, message.tag, segment_comm_,
                    sends_.add(message.out)),
          "MPI_Isend");
    node_.ring(to);
  }
}

/// Segments of different packets to one rank have different tags until the tags run out. MPI keeps messages
/// of one tag in order, so that even then they are matched as they were sent.
std::int32_t MpiTransport::Impl::next_tag(Rank to) {
  return static_cast<std::int32_t>(tagged_[to.index()]++ % tags_);
}

// ---- receiving

void MpiTransport::Impl::check_usable() const {
  if (state_ == State::kAbandoned) throw TransportError("the network has been abandoned");
  if (!broken_.empty()) throw TransportError(broken_);
}

bool MpiTransport::Impl::poll(const Receive& receive) {
  check_usable();
  if (state_ == State::kClosed) throw TransportError("the network is closed");
  // Sends first: what they free is there for what comes in.
  bool any = sends_.test([&](const std::shared_ptr<Outgoing>& out) {
    --unsent_[out->to.index()];
    node_.ring(out->to);  // of a long head it may have slept since its first part came
  });
  if (!queued_.empty()) or_break("sent to", queued_.front().out->to, [&] { post_queued(); });
  any |= receive_heads(receive);
  any |= receives_.test([&](const std::shared_ptr<Incoming>& in) {
    or_break("received from", in->from, [&] { take_finished(in); });
  });
  any |= deliver(receive);
  if (any) quiet_ = looks_ = 0;
  return any;
}

/// At most a ring full, so that the caller gets its turn.
bool MpiTransport::Impl::receive_heads(const Receive& receive) {
  for (std::size_t handled = 0; handled < kHeadReceives; ++handled) {
    HeadReceive& slot = heads_[head_];
    int arrived = 0, bytes = 0;
    MPI_Status status;
    check(MPI_Test(&slot.request, &arrived, &status), "MPI_Test");
    if (!arrived) return handled > 0;
    slot.posted = false;
    head_ = (head_ + 1) % kHeadReceives;
    check(MPI_Get_count(&status, MPI_BYTE, &bytes), "MPI_Get_count");
    try {
      take_head(Rank(status.MPI_SOURCE), status.MPI_TAG,
                {slot.buffer.data(), static_cast<std::size_t>(bytes)}, receive);
    } catch (...) {
      post(slot);  // else the ring would come to it only after 15 more, and wait for what others have taken
      throw;
    }
    post(slot);
  }
  return true;
}

void MpiTransport::Impl::take_head(Rank from, int tag, std::span<const std::byte> message,
                                   const Receive& receive) {
  if (tag == kHeadTag) return or_break("received from", from, [&] { expect_segments(from, message); });
  ++received_[from.index()];
  if (tag != kLoneHeadTag) return note_leaving(from, tag, message);
  receive(from, message, {});
}

void MpiTransport::Impl::note_leaving(Rank from, int tag, std::span<const std::byte> message) {
  LeaveNotice notice{from, 0, {}, tag == kLeaveTag};
  std::memcpy(&notice.ended_phase, message.data(), sizeof notice.ended_phase);
  const auto why = message.subspan(sizeof notice.ended_phase);
  notice.why.assign(reinterpret_cast<const char*>(why.data()), why.size());
  notices_.push_back(std::move(notice));
}

void MpiTransport::Impl::expect_segments(Rank from, std::span<const std::byte> message) {
  Trailer trailer;
  const auto head_and_sizes = message.first(message.size() - sizeof trailer);
  std::memcpy(&trailer, head_and_sizes.data() + head_and_sizes.size(), sizeof trailer);
  const auto in = std::make_shared<Incoming>();
  in->from = from;
  in->tag = trailer.tag;
  in->sizes.resize(trailer.segments);
  const std::size_t bytes = in->sizes.size() * sizeof(Sizes::value_type);
  in->sizes_known = in->sizes.size() <= kInlineSizes;
  const auto head = head_and_sizes.first(head_and_sizes.size() - (in->sizes_known ? bytes : 0));
  in->head.assign(head.begin(), head.end());
  if (in->sizes_known) {
    std::memcpy(in->sizes.data(), head.data() + head.size(), bytes);
    post_segments(in);
  } else {
    receive_bytes(in, in->sizes.data(), bytes);
  }
  node_.ring(from);  // it may be asleep with nothing to do until we are ready
}

void MpiTransport::Impl::post_segments(const std::shared_ptr<Incoming>& in) {
  in->segments.reserve(in->sizes.size());
  for (const std::uint64_t size : in->sizes) {
    Blob& segment = in->segments.emplace_back(Blob::allocate(size));
    receive_bytes(in, segment.data(), segment.size());
  }
  if (in->open == 0) take_finished(in);  // all of 0 bytes
}

void MpiTransport::Impl::receive_bytes(const std::shared_ptr<Incoming>& in, void* data, std::size_t size) {
  for (std::size_t done = 0; done < size; done += chunk_) {
    const auto count = static_cast<int>(std::min(chunk_, size - done));
    ++in->open;
    check(MPI_Irecv(static_cast<std::byte*>(data) + done, count, MPI_BYTE, in->from.value, in->tag,
                    segment_comm_, receives_.add(in)),
          "MPI_Irecv");
  }
}

/// All messages asked for so far are here: the packet is complete, or its segments' sizes are.
void MpiTransport::Impl::take_finished(const std::shared_ptr<Incoming>& in) {
  node_.ring(in->from);  // its sends are done, too
  if (!in->sizes_known) {
    in->sizes_known = true;
    return post_segments(in);
  }
  ++received_[in->from.index()];
  arrived_.push_back({in->from, std::move(in->head), std::move(in->segments)});
}

bool MpiTransport::Impl::deliver(const Receive& receive) {
  const std::size_t count = arrived_.size();  // not those that `receive` sends to this rank
  for (std::size_t i = 0; i < count; ++i) {
    Arrived packet = std::move(arrived_.front());
    arrived_.pop_front();
    receive(packet.from, packet.head, std::move(packet.segments));
  }
  return count > 0;
}

// ---- sleeping

void MpiTransport::Impl::wait(std::chrono::nanoseconds at_most) {
  check_usable();
  if (!arrived_.empty()) return;
  const bool busy = !sends_.empty() || !receives_.empty();
  if (looks_ > 0 || (busy && quiet_ < kYields)) {
    looks_ > 0 ? --looks_ : ++quiet_;
    sched_yield();
    return;
  }
  Sleeper& bell = node_.own().bell;
  bell.wait(seen_, std::min(at_most, longest_sleep()));
  if (bell.ticket() != seen_) looks_ = kLooks;
  // Drawn here only: whatever rings from now on ends the next wait(), whether poll() has seen its cause or
  // not.
  seen_ = bell.ticket();
}

/// Longer the longer nothing happens. MPI moves nothing on while we sleep, and of what peers on other nodes
/// do we hear nothing.
std::chrono::nanoseconds MpiTransport::Impl::longest_sleep() {
  const bool busy = !sends_.empty() || !receives_.empty();
  if (!busy && node_.has_all() && state_ == State::kOpen) return kLongestSleep;
  const int doublings = std::min(std::max(++quiet_ - kYields, 0), 10);
  return std::min(kShortestSleep * (1 << doublings), kLongestRemoteSleep);
}

// ---- the end

void MpiTransport::Impl::close() {
  check_usable();
  if (state_ == State::kClosed) return;
  state_ = State::kClosing;
  arrived_.clear();
  expected_.resize(sent_.size());
  MPI_Request request = MPI_REQUEST_NULL;
  // Not on the communicator of the heads: on one rank MPICH 4.0 lets receives with any tag take the messages
  // of its collective calls.
  check(MPI_Ialltoall(sent_.data(), 1, MPI_UINT64_T, expected_.data(), 1, MPI_UINT64_T, segment_comm_,
                      &request),
        "MPI_Ialltoall");
  node_.ring_all();
  finish(request);
  while (received_ != expected_ || !sends_.empty() || !receives_.empty()) drop();
  // Behind this nobody sends anything: the receives in advance can go.
  check(MPI_Ibarrier(segment_comm_, &request), "MPI_Ibarrier");
  node_.ring_all();
  finish(request);
  cancel_heads();
  node_.own().closed = true;
  for (MPI_Comm* communicator : {&head_comm_, &segment_comm_})
    check(MPI_Comm_free(communicator), "MPI_Comm_free");
  if (mpi_ == Mpi::own) check(MPI_Finalize(), "MPI_Finalize");
  state_ = State::kClosed;
}

/// Waits for a collective call; meanwhile packets are received and dropped, so that no sender is held up
/// before its own call.
void MpiTransport::Impl::finish(MPI_Request request) {
  for (;;) {
    int done = 0;
    check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
    if (done) return;
    drop();
  }
}

void MpiTransport::Impl::drop() {
  if (poll([](Rank, std::span<const std::byte>, std::vector<Blob>) {})) return;
  wait(kLongestSleep);
  check_deaths();
}

void MpiTransport::Impl::check_deaths() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_death_watch_) return;
  next_death_watch_ = now + kDeathWatch;
  if (const auto rank = node_.dead()) {
    throw TransportError("rank " + std::to_string(rank->value) +
                         " has died; the network cannot be closed without it");
  }
  for (const LeaveNotice& notice : notices_) {
    if (notice.will_close) continue;
    throw TransportError("rank " + std::to_string(notice.rank.value) + " " + notice.why +
                         "; the network cannot be closed without it");
  }
}

void MpiTransport::Impl::cancel_heads() {
  for (HeadReceive& slot : heads_) {
    if (slot.posted) {
      check(MPI_Cancel(&slot.request), "MPI_Cancel");
      check(MPI_Wait(&slot.request, MPI_STATUS_IGNORE), "MPI_Wait");
    }
    check(MPI_Request_free(&slot.request), "MPI_Request_free");
  }
}

void MpiTransport::Impl::abandon(std::uint64_t ended_phase) noexcept {
  if (state_ == State::kClosed || state_ == State::kAbandoned) return;
  if (mpi_ == Mpi::own) MPI_Abort(MPI_COMM_WORLD, 2);
  depart(kAbandonTag, ended_phase, "has abandoned the network");
  state_ = State::kAbandoned;
}

// ---- the class as others see it

bool under_mpirun() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"}) {
    if (std::getenv(name)) return !inherited_from_rank(name);
  }
  return false;
}

bool mpi_is_running() {
  int initialized = 0, finalized = 0;
  check(MPI_Initialized(&initialized), "MPI_Initialized");
  check(MPI_Finalized(&finalized), "MPI_Finalized");
  return initialized && !finalized;
}

CallersCommunicator world_of_caller() {
  static const MPI_Comm world = MPI_COMM_WORLD;
  return {&world};
}

MpiTransport::MpiTransport(int* argc, char*** argv, MpiTransportOptions options) {
  start_mpi(argc, argv);
  impl_ = std::make_unique<Impl>(MPI_COMM_WORLD, Impl::Mpi::own, options);
}

MpiTransport::MpiTransport(CallersCommunicator communicator, MpiTransportOptions options)
    : impl_(std::make_unique<Impl>(checked(communicator), Impl::Mpi::callers, options)) {}

MpiTransport::~MpiTransport() {
  impl_->abandon(ended_phase());
  if (impl_->abandoned()) Impl::leave_behind(std::move(impl_));
}

Rank MpiTransport::rank() const { return impl_->rank(); }
int MpiTransport::size() const { return impl_->size(); }
void MpiTransport::send(Rank to, Packet packet) { impl_->send(to, std::move(packet)); }
bool MpiTransport::poll(const Receive& receive) { return impl_->poll(receive); }
std::size_t MpiTransport::unsent(Rank to) const { return impl_->unsent(to); }
void MpiTransport::wait(std::chrono::nanoseconds at_most) { impl_->wait(at_most); }
void MpiTransport::wake() noexcept { impl_->wake(); }
std::optional<LostPeer> MpiTransport::lost_peer() {
  if (const auto dead = impl_->dead()) return LostPeer{*dead, "died: its process is gone"};
  return missed_in(phase(), impl_->notices());
}
bool MpiTransport::watches(Rank rank) const { return impl_->watches(rank); }
void MpiTransport::leave(const std::string& why) noexcept { impl_->leave(ended_phase(), why); }
void MpiTransport::close() { impl_->close(); }
void MpiTransport::abandon() noexcept { impl_->abandon(ended_phase()); }
bool MpiTransport::abandoning_ends_process() const { return impl_->owns_mpi(); }
std::vector<std::pair<std::string, long>> MpiTransport::calls() const { return mpi_calls(); }

}  // namespace weft::engine

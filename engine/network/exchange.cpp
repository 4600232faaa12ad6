// Aggregation and credit.
#include "engine/network/exchange.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace weft::engine {
namespace {

/// What all frames of a packet are.
enum Verdicts : std::uint32_t { kNoVerdicts, kOfARun, kOfTheNetwork };

/// First bytes of every packet.
struct PacketHeader {
  std::uint64_t program;
  double load;
  std::uint64_t credit;  ///< counted bytes that the sender of this packet has consumed
  std::uint64_t phase;
  std::uint32_t frames;
  Verdicts verdicts;
};

/// First bytes of every frame; `bytes` follow here, or are the first of its segments when they are too many.
struct FrameHeader {
  std::uint64_t bytes;
  std::uint32_t segments;
  FrameKind kind;
  bool bytes_are_segment;
};

constexpr std::size_t kLargestInline = Transport::kMaxHead / 4;
// Two packets keep the network busy; what is posted meanwhile goes together in the next.
constexpr std::size_t kPacketsUnderWay = 2;
constexpr std::size_t kLeastWindow = 4096;

/// Of one peer.
std::size_t window_of(const ExchangeOptions& options, int ranks) {
  const auto peers = static_cast<std::size_t>(std::max(1, ranks - 1));
  return std::max(std::min(options.window_bytes, options.inbox_bytes / peers), kLeastWindow);
}

Verdicts verdicts_of(FrameKind kind) {
  if (kind == FrameKind::broken) return kOfTheNetwork;
  return kind == FrameKind::stop || kind == FrameKind::failure ? kOfARun : kNoVerdicts;
}

/// Heard by who has left the run, too, and waits for who has not.
bool tells_of_life(FrameKind kind) { return kind == FrameKind::heartbeat || kind == FrameKind::leaving; }

bool is_counted(FrameKind kind) { return kind == FrameKind::task || kind == FrameKind::object; }

template <class T>
void append_plain(std::vector<std::byte>& to, const T& value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  to.insert(to.end(), first, first + sizeof value);
}

template <class T>
T take_plain(std::span<const std::byte>& from) {
  if (from.size() < sizeof(T)) throw TransportError("a packet ends inside a header");
  T value;
  std::memcpy(&value, from.data(), sizeof value);
  from = from.subspan(sizeof value);
  return value;
}

}  // namespace

Exchange::Exchange(Transport& transport, ExchangeOptions options, std::uint64_t program)
    : transport_(transport),
      window_(window_of(options, transport.size())),
      backlog_bytes_(options.backlog_bytes),
      program_(program ^ (sizeof(PacketHeader) << 8 | sizeof(FrameHeader))),
      peers_(static_cast<std::size_t>(transport.size())),
      credits_(peers_.size()),
      loads_(peers_.size()) {}

Exchange::Peer& Exchange::peer_of(Rank rank) {
  std::unique_ptr<Peer>& peer = peers_[rank.index()];
  if (!peer) peer = std::make_unique<Peer>();
  return *peer;
}

void Exchange::post(Rank to, FrameKind kind, Payload payload) {
  if (!to.valid() || to.index() >= peers_.size())
    throw std::out_of_range("there is no rank " + std::to_string(to.value) + " to send to");
  const std::size_t wire_bytes = payload.size() + sizeof(FrameHeader);
  if (is_counted(kind)) backlog_ += wire_bytes;
  bool first;
  {
    const std::lock_guard lock(mutex_);
    first = posted_.empty();
    posted_.push_back({to, {kind, std::move(payload), wire_bytes}});
  }
  if (first) transport_.wake();
}

void Exchange::wait_for_room() {
  if (backlog_.load(std::memory_order_relaxed) <= backlog_bytes_) return;
  std::unique_lock lock(mutex_);
  room_.wait(lock, [this] { return released_ || backlog_ <= backlog_bytes_ || inbox_ > 0; });
}

void Exchange::release_waiters() {
  {
    const std::lock_guard lock(mutex_);
    released_ = true;
  }
  room_.notify_all();
}

void Exchange::consumed(Rank from, std::size_t wire_bytes) {
  inbox_ -= static_cast<std::int64_t>(wire_bytes);
  const std::uint64_t before = credits_.add(from.index(), wire_bytes);
  const std::uint64_t due = window_ / 4;
  // One message to the sender for a quarter of a window: it never runs dry, and small messages cost no reply
  // each.
  if (before < due && before + wire_bytes >= due) {
    credits_due_ = true;
    transport_.wake();
  }
}

void Exchange::begin_phase() {
  phase_ = first_phase_ == 0 ? first_phase_ = transport_.first_phase() : transport_.next_phase();
  failed_phase_ = 0;
  hears_later_failures_ = later_phase_failed_ = false;
  look_at_kept_ = true;
  const std::lock_guard lock(mutex_);
  released_ = false;
}

void Exchange::hear_later_failures() { hears_later_failures_ = look_at_kept_ = true; }

bool Exchange::idle() {
  take_posted();
  return pending_peers_.empty() && transport_.all_sent();
}

bool Exchange::urgent_idle() {
  take_posted();
  // Whoever has frames is pending.
  return transport_.all_sent() && std::all_of(pending_peers_.begin(), pending_peers_.end(),
                                              [this](Rank rank) { return peer_of(rank).urgent.empty(); });
}

bool Exchange::progress(const Receive& receive) {
  bool busy = false;
  if (std::exchange(look_at_kept_, false)) {
    std::vector<KeptPacket> packets = transport_.take_kept();
    for (std::size_t i = 0; i < packets.size(); ++i) {
      try {
        unpack(packets[i].from, packets[i].head, std::move(packets[i].segments), receive);
      } catch (...) {  // those behind it are looked at the next time
        look_at_kept_ = true;
        while (++i < packets.size()) transport_.keep(std::move(packets[i]));
        throw;
      }
      busy = true;
    }
  }
  busy |= take_posted();
  if (credits_due_.exchange(false)) {
    credits_.each_from(window_ / 4, [&](std::size_t r) {
      const Rank to(static_cast<int>(r));
      send_packet(to, peer_of(to), credits_.take(r));
      busy = true;
    });
  }
  std::size_t kept = 0;
  for (const Rank to : pending_peers_) {
    Peer& peer = peer_of(to);
    busy |= flush(to, peer);
    peer.pending = !peer.urgent.empty() || !peer.waiting.empty();
    if (peer.pending) pending_peers_[kept++] = to;
  }
  pending_peers_.resize(kept);
  busy |= transport_.poll([&](Rank from, std::span<const std::byte> head, std::vector<Blob> segments) {
    unpack(from, head, std::move(segments), receive);
  });
  return busy;
}

bool Exchange::take_posted() {
  {
    const std::lock_guard lock(mutex_);
    std::swap(posted_, taken_);
  }
  const bool any = !taken_.empty();
  for (Posted& posted : taken_) {
    Peer& peer = peer_of(posted.to);
    (is_counted(posted.frame.kind) ? peer.waiting : peer.urgent).push_back(std::move(posted.frame));
    if (!std::exchange(peer.pending, true)) pending_peers_.push_back(posted.to);
  }
  taken_.clear();
  return any;
}

Exchange::Traffic Exchange::traffic() const {
  Traffic traffic{backlog_, static_cast<std::uint64_t>(std::max<std::int64_t>(inbox_, 0)), {}};
  peers_.each([&](std::size_t r, const std::unique_ptr<Peer>& peer) {
    if (peer && peer->under_way > 0)
      traffic.unconfirmed.emplace_back(Rank(static_cast<int>(r)), peer->under_way);
  });
  return traffic;
}

bool Exchange::may_send(const Peer& peer) const {
  if (!peer.urgent.empty()) return true;
  if (peer.waiting.empty()) return false;
  // Up to a quarter may have been consumed without our being told, and must not hold up a message of any
  // size.
  return peer.under_way < window_ / 4 || peer.under_way + peer.waiting.front().wire_bytes <= window_;
}

bool Exchange::flush(Rank to, Peer& peer) {
  bool any = false;
  while (may_send(peer) && (!peer.urgent.empty() || transport_.unsent(to) < kPacketsUnderWay)) {
    send_packet(to, peer, credits_.take(to.index()));
    any = true;
  }
  return any;
}

void Exchange::send_packet(Rank to, Peer& peer, std::uint64_t credit) {
  Packet packet;
  PacketHeader header{program_, load_, credit, phase_, 0, kNoVerdicts};
  packet.head.reserve(256);
  append_plain(packet.head, header);
  std::size_t sent_bytes = 0;
  while (may_send(peer)) {
    Queue& queue = peer.urgent.empty() ? peer.waiting : peer.urgent;
    const std::size_t inlined =
        queue.front().payload.bytes.size() > kLargestInline ? 0 : queue.front().payload.bytes.size();
    if (packet.head.size() + sizeof(FrameHeader) + inlined > Transport::kMaxHead) break;
    const Verdicts verdicts = verdicts_of(queue.front().kind);
    if (header.frames > 0 && verdicts != header.verdicts) break;
    header.verdicts = verdicts;
    if (verdicts != kNoVerdicts && failed_phase_ > 0) header.phase = failed_phase_;
    if (is_counted(queue.front().kind)) {
      peer.under_way += queue.front().wire_bytes;
      sent_bytes += queue.front().wire_bytes;
    }
    append(packet, std::move(queue.front()));
    queue.pop_front();
    ++header.frames;
  }
  std::memcpy(packet.head.data(), &header, sizeof header);
  transport_.send(to, std::move(packet));
  ++packets_sent_;
  if (sent_bytes == 0) return;
  const std::size_t before = backlog_.fetch_sub(sent_bytes);
  if (before > backlog_bytes_ && before - sent_bytes <= backlog_bytes_) {
    { const std::lock_guard lock(mutex_); }  // a worker between its test and its wait must not miss this
    room_.notify_all();
  }
}

void Exchange::append(Packet& packet, Frame frame) {
  std::vector<std::byte>& bytes = frame.payload.bytes;
  const bool as_segment = bytes.size() > kLargestInline;
  append_plain(packet.head,
               FrameHeader{bytes.size(), static_cast<std::uint32_t>(frame.payload.segments.size()),
                           frame.kind, as_segment});
  if (as_segment) {
    packet.segments.push_back(Blob::adopt(std::move(bytes)));
  } else {
    packet.head.insert(packet.head.end(), bytes.begin(), bytes.end());
  }
  for (Blob& segment : frame.payload.segments) packet.segments.push_back(std::move(segment));
}

void Exchange::unpack(Rank from, std::span<const std::byte> head, std::vector<Blob> segments,
                      const Receive& receive) {
  const std::span<const std::byte> whole = head;
  const auto header = take_plain<PacketHeader>(head);
  if (header.phase < first_phase_) return;  // of an engine that is no more
  const bool of_a_run = header.verdicts == kOfARun;
  const bool early = of_a_run && hears_later_failures_ && header.phase > phase_ &&
                     header.phase < first_phase_ + Transport::kPhasesOfAUser;
  const bool at_once = header.verdicts == kOfTheNetwork || early;
  if (header.phase > phase_ && !at_once)
    return transport_.keep({from, {whole.begin(), whole.end()}, std::move(segments)});
  later_phase_failed_ |= early;
  const bool late = of_a_run && header.phase < phase_;
  if (late && (failed_phase_ == 0 || header.phase < failed_phase_)) failed_phase_ = header.phase;
  const bool heard = header.phase == phase_ || at_once || late;
  Peer& peer = peer_of(from);
  if (from != transport_.rank()) loads_.set(from, header.load);
  if (header.credit > peer.under_way) throw TransportError("a rank confirms more than was sent to it");
  peer.under_way -= header.credit;
  auto segment = segments.begin();
  const auto take_segment = [&] {
    if (segment == segments.end()) throw TransportError("a packet lacks a segment");
    return std::move(*segment++);
  };
  std::exception_ptr failure;
  const bool same_program = header.program == program_;
  if (!same_program) {
    failure = std::make_exception_ptr(
        std::runtime_error("rank " + std::to_string(from.value) +
                           " runs another program (its objects and methods are not the same)"));
  }
  for (std::uint32_t i = 0; i < header.frames; ++i) {
    const auto frame_header = take_plain<FrameHeader>(head);
    Frame frame{frame_header.kind, {}, 0};
    std::vector<std::byte>& bytes = frame.payload.bytes;
    if (frame_header.bytes_are_segment) {
      const Blob blob = take_segment();
      bytes.assign(blob.data(), blob.data() + blob.size());
    } else {
      if (head.size() < frame_header.bytes) throw TransportError("a packet ends inside a frame");
      bytes.assign(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(frame_header.bytes));
      head = head.subspan(frame_header.bytes);
    }
    frame.payload.segments.reserve(frame_header.segments);
    for (std::uint32_t s = 0; s < frame_header.segments; ++s)
      frame.payload.segments.push_back(take_segment());
    frame.wire_bytes = frame.payload.size() + sizeof(FrameHeader);
    if (!heard && !tells_of_life(frame.kind)) continue;
    if (!same_program && is_counted(frame.kind)) continue;
    try {
      deliver(from, std::move(frame), receive);
    } catch (...) {  // the frames behind it are no worse for it: one may be the stop that all wait for
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

void Exchange::deliver(Rank from, Frame frame, const Receive& receive) {
  if (is_counted(frame.kind)) {
    if (inbox_.fetch_add(static_cast<std::int64_t>(frame.wire_bytes)) ==
        0) {  // handlers must not be held up any more
      { const std::lock_guard lock(mutex_); }
      room_.notify_all();
    }
  }
  receive(from, frame.kind, std::move(frame.payload), frame.wire_bytes);
}

}  // namespace weft::engine

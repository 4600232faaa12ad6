// What every Transport must do, as functions to be run on all ranks of any network.
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "engine/network/transport.h"

namespace weft::engine::contract {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// Longer than anything here takes, under sanitizers on a busy machine: a hang becomes a failure.
constexpr auto kPatience = 100s;

inline std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

/// Bytes that tell from which `seed` they come and that are not in place when shifted.
inline void fill(std::span<std::byte> bytes, std::uint64_t seed) {
  std::uint64_t state = seed * 0x9E3779B97F4A7C15u + 1;
  for (std::byte& byte : bytes) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    byte = static_cast<std::byte>(state >> 56);
  }
}

inline std::uint64_t checksum(std::span<const std::byte> bytes) {
  std::uint64_t sum = 14695981039346656037u;
  for (const std::byte byte : bytes) sum = (sum ^ static_cast<std::uint64_t>(byte)) * 1099511628211u;
  return sum;
}

inline Blob random_blob(std::size_t size, std::uint64_t seed) {
  Blob blob = Blob::allocate(size);
  fill({blob.data(), blob.size()}, seed);
  return blob;
}

/// What has come in at a rank.
struct Received {
  Rank from;
  std::vector<std::byte> head;
  std::vector<Blob> segments;
};

/// A rank's loop in the smallest: polls into an inbox. One per transport, for all tests that use it.
class Player {
 public:
  explicit Player(Transport& transport) : transport_(transport) {}

  Transport& transport() { return transport_; }
  Rank rank() const { return transport_.rank(); }
  int size() const { return transport_.size(); }
  Rank next() const { return Rank((rank().value + 1) % size()); }

  void send(Rank to, std::vector<std::byte> head, std::vector<Blob> segments = {}) {
    transport_.send(to, Packet{std::move(head), std::move(segments)});
  }

  bool poll() {
    return poll([this](Received received) { inbox_.push_back(std::move(received)); });
  }

  /// Packets go to handle(Received), called from within the transport's poll().
  template <class Handle>
  bool poll(const Handle& handle) {
    return transport_.poll([&](Rank from, std::span<const std::byte> head, std::vector<Blob> segments) {
      Received received{from, {head.begin(), head.end()}, std::move(segments)};
      if (!is_of_meeting(received)) handle(std::move(received));
    });
  }

  bool has_mail() const { return !inbox_.empty(); }

  /// The next packet, slept for.
  Received await() {
    until([this] { return has_mail(); });
    Received received = std::move(inbox_.front());
    inbox_.pop_front();
    return received;
  }

  template <class Condition>
  void until(const Condition& condition) {
    const auto deadline = Clock::now() + kPatience;
    while (!condition()) {
      if (poll()) continue;
      if (Clock::now() > deadline) throw std::runtime_error("nothing happened for too long");
      transport_.wait(100ms);
    }
  }

  /// Waits for all ranks. Call it at the end of every test: packets of a faster rank's next test are kept for
  /// it.
  void meet() {
    EXPECT_TRUE(inbox_.empty()) << inbox_.size() << " packets too many at " << rank();
    inbox_.clear();
    meeting_ = true;
    if (rank() == Rank(0)) {
      until([this] { return arrivals_ >= size() - 1; });
      arrivals_ -= size() - 1;
      for (int to = 1; to < size(); ++to) send(Rank(to), bytes_of(kGoOn));
    } else {
      send(Rank(0), bytes_of(kArrived));
      until([this] { return !meeting_; });
    }
    meeting_ = false;
    until([this] { return all_sent(); });
  }

  bool all_sent() const {
    for (int to = 0; to < size(); ++to) {
      if (transport_.unsent(Rank(to)) > 0) return false;
    }
    return true;
  }

 private:
  static constexpr std::string_view kArrived = "meeting: I am here", kGoOn = "meeting: all are here";

  bool is_of_meeting(const Received& received) {
    const bool arrival = received.head == bytes_of(kArrived), end = received.head == bytes_of(kGoOn);
    if (arrival) ++arrivals_;
    if (end) meeting_ = false;
    return arrival || end;
  }

  Transport& transport_;
  std::deque<Received> inbox_;
  int arrivals_ = 0;
  bool meeting_ = false;
};

/// Runs a function on every rank of a network and returns when it has ended on all those of this process.
using OnEveryRank = std::function<void(const std::function<void(Player&)>&)>;

// ---- the contract, a function a clause

/// Packets of all shapes to the next rank (this one, when it is alone) arrive as they were sent.
inline void shapes_arrive(Player& me, std::size_t largest) {
  struct Shape {
    std::size_t head;
    std::vector<std::size_t> segments;
  };
  const std::vector<Shape> shapes = {
      {0, {}},
      {1, {}},
      {Transport::kMaxHead, {}},
      {0, {0}},
      {5, {0, 0, 0}},
      {0, {1}},
      {100, {7, 0, 4096, 0, 4097}},
      {Transport::kMaxHead, std::vector<std::size_t>(64, 10)},
      {Transport::kMaxHead, std::vector<std::size_t>(65, 10)},
      {3, std::vector<std::size_t>(1000, 33)},
      {3, std::vector<std::size_t>(1000, 0)},
      {8, {999, 1000, 1001, 2000, 2001}},
      {8, {largest, 3, largest / 2 + 1}},
  };
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto& shape = shapes[i];
    std::vector<std::byte> head(shape.head);
    fill(head, i);
    std::vector<Blob> segments;
    for (std::size_t k = 0; k < shape.segments.size(); ++k)
      segments.push_back(random_blob(shape.segments[k], i + k));
    me.send(me.next(), std::move(head), std::move(segments));

    const Received received = me.await();
    EXPECT_EQ(received.from, Rank((me.rank().value + me.size() - 1) % me.size()));
    std::vector<std::byte> expected_head(shape.head);
    fill(expected_head, i);
    EXPECT_TRUE(received.head == expected_head) << "head of shape " << i;
    ASSERT_EQ(received.segments.size(), shape.segments.size()) << "shape " << i;
    for (std::size_t k = 0; k < shape.segments.size(); ++k) {
      const Blob expected = random_blob(shape.segments[k], i + k);
      EXPECT_TRUE(std::ranges::equal(received.segments[k].bytes(), expected.bytes()))
          << "shape " << i << ", " << k;
    }
    me.meet();  // shapes may overtake each other
  }
}

inline void misuse_is_refused(Player& me) {
  EXPECT_THROW(me.send(me.next(), std::vector<std::byte>(Transport::kMaxHead + 1)), TransportError);
  EXPECT_THROW(me.send(Rank(me.size()), {}), TransportError);
  EXPECT_THROW(me.send(Rank(), {}), TransportError);
  me.meet();
}

/// A packet to oneself arrives at the next poll(), not within send(), and wait() does not sleep over it.
inline void self_sends(Player& me) {
  me.send(me.rank(), bytes_of("to myself"));
  EXPECT_FALSE(me.has_mail());
  const auto start = Clock::now();
  me.transport().wait(20s);
  EXPECT_LT(Clock::now() - start, 10s);
  me.until([&] { return me.has_mail(); });
  const Received received = me.await();
  EXPECT_EQ(received.from, me.rank());
  EXPECT_TRUE(received.head == bytes_of("to myself"));
  me.meet();
}

/// Every packet of random traffic among all ranks arrives once and whole.
inline void all_to_all(Player& me, int packets, std::size_t largest_segment) {
  std::mt19937_64 random(static_cast<std::uint64_t>(me.rank().value) + 1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  struct Label {
    std::int64_t number;
    std::uint64_t sum;
    std::int64_t segments;
  };
  std::vector<std::vector<bool>> seen(static_cast<std::size_t>(me.size()));
  for (auto& of_rank : seen) of_rank.resize(static_cast<std::size_t>(packets));
  const int expected = packets * me.size();
  int got = 0;
  const auto take = [&] {
    const Received received = me.await();
    Label label;
    ASSERT_GE(received.head.size(), sizeof label);
    std::memcpy(&label, received.head.data(), sizeof label);
    std::uint64_t sum = checksum(std::span(received.head).subspan(sizeof label));
    for (const Blob& segment : received.segments) sum += checksum(segment.bytes()) + segment.size();
    EXPECT_EQ(sum, label.sum);
    EXPECT_EQ(static_cast<std::int64_t>(received.segments.size()), label.segments);
    const auto number = static_cast<std::size_t>(label.number);
    EXPECT_FALSE(seen[received.from.index()][number]) << "a packet came twice";
    seen[received.from.index()][number] = true;
    ++got;
  };
  for (int number = 0; number < packets; ++number) {
    for (int to = 0; to < me.size(); ++to) {
      const bool large = below(10) == 0;
      std::vector<std::byte> head(sizeof(Label) + below(large ? 30000 : 200));
      fill(std::span(head).subspan(sizeof(Label)), random());
      std::vector<Blob> segments;
      for (std::size_t k = below(4); k-- > 0;) {
        segments.push_back(random_blob(below(large ? largest_segment : 500), random()));
      }
      std::uint64_t sum = checksum(std::span(head).subspan(sizeof(Label)));
      for (const Blob& segment : segments) sum += checksum(segment.bytes()) + segment.size();
      const Label label{number, sum, static_cast<std::int64_t>(segments.size())};
      std::memcpy(head.data(), &label, sizeof label);
      me.send(Rank(to), std::move(head), std::move(segments));
    }
    me.poll();
    while (me.has_mail()) take();
  }
  while (got < expected) take();
  me.meet();
}

/// receive may send: a token goes round the ring from within it, with a segment that stays one and the same.
inline void receivers_may_send(Player& me, int rounds) {
  int seen = 0;
  const auto send_token = [&](int left, std::vector<Blob> segments) {
    std::vector<std::byte> head(sizeof left);
    std::memcpy(head.data(), &left, sizeof left);
    me.send(me.next(), std::move(head), std::move(segments));
  };
  const auto pass_on = [&](Received received) {
    ++seen;
    int left = 0;
    ASSERT_EQ(received.head.size(), sizeof left);
    std::memcpy(&left, received.head.data(), sizeof left);
    if (left > 1) send_token(left - 1, std::move(received.segments));
  };
  if (me.rank() == Rank(0)) {
    std::vector<Blob> segments;
    segments.push_back(random_blob(100000, 1));
    send_token(rounds * me.size(), std::move(segments));
  }
  while (me.has_mail()) pass_on(me.await());  // the token may have been faster than the end of the last test
  const auto deadline = Clock::now() + kPatience;
  while (seen < rounds && Clock::now() < deadline) {
    if (!me.poll(pass_on)) me.transport().wait(10ms);
  }
  EXPECT_EQ(seen, rounds);
  me.meet();
}

/// A receiver that throws loses the packet it was given, and nothing else, whatever comes later.
inline void receivers_may_throw(Player& me) {
  constexpr int kPackets = 20;
  for (int i = 0; i < kPackets; ++i) me.send(me.next(), bytes_of("one of twenty"));
  int received = 0;
  while (me.has_mail()) {
    me.await();
    ++received;
  }
  bool thrown = false;
  const auto receive = [&](Received) {
    ++received;
    if (std::exchange(thrown, true)) return;
    throw std::runtime_error("I do not like this one");
  };
  const auto deadline = Clock::now() + 10s;
  while (received < kPackets && Clock::now() < deadline) {
    try {
      if (!me.poll(receive)) me.transport().wait(10ms);
    } catch (const std::runtime_error&) {
    }
  }
  EXPECT_EQ(received, kPackets);
  me.meet();
}

/// wake() ends a wait(), and is remembered when none is going on, whatever is polled in between.
inline void wakes(Player& me) {
  const auto waited = [&] {
    // wait() may return early for no reason, so that only the fact that it returns can be tested.
    const auto start = Clock::now();
    me.transport().wait(20s);
    return Clock::now() - start;
  };
  me.transport().wake();
  EXPECT_LT(waited(), 10s);
  me.transport().wake();
  me.poll();
  EXPECT_LT(waited(), 10s);
  std::atomic<bool> woken = false;
  std::thread waker([&] {
    std::this_thread::sleep_for(20ms);
    woken = true;
    me.transport().wake();
  });
  const auto start = Clock::now();
  while (!woken) me.transport().wait(20s);
  EXPECT_LT(Clock::now() - start, 10s);
  waker.join();
  me.meet();
}

inline double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A rank with nothing to do needs next to no processor time; a little more where nobody can ring, and it has
/// to look each half millisecond.
inline constexpr double kIdleShare = 0.05, kIdleShareWithoutBells = 0.15;
inline void idles_cheaply(Player& me, double most = kIdleShare) {
  me.meet();
  const auto start = Clock::now();
  const double before = thread_seconds();
  int mails = 0;
  while (Clock::now() - start < 1s) {
    mails += me.poll();
    me.transport().wait(100ms);
  }
  const double used = thread_seconds() - before;
  EXPECT_LT(used, most) << "of a core, where polling would take all of it and waking every 0.5 ms some 0.05";
  if (me.rank() == Rank(0)) std::printf("idle: %.3f %% of a core\n", 100 * used);
  EXPECT_LE(mails, me.size() * 2);  // others' arrival at the meeting
  me.meet();
}

/// A packet wakes a rank that sleeps: rank 0 sends one to the sleeping rank 1, which answers while rank 0
/// sleeps. How soon is printed, and measured in the benchmark; the bound is that of a machine on which a rank
/// that has been woken has to wait long for a processor.
inline void sleepers_wake_soon(Player& me) {
  constexpr int kTries = 100;
  std::vector<double> delays;
  if (me.size() > 1 && me.rank() == Rank(0)) {
    for (int i = 0; i < kTries; ++i) {
      std::this_thread::sleep_for(3ms);  // rank 1 falls asleep
      const auto start = Clock::now();
      me.send(Rank(1), bytes_of("ping"));
      me.await();
      delays.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count() / 2);
    }
    std::ranges::sort(delays);
    const double soon = delays[kTries / 10], median = delays[kTries / 2];
    std::printf("a sleeping rank wakes within %.1f us (median; fastest tenth: %.1f us)\n", median, soon);
    EXPECT_LT(soon, 50'000);
  }
  if (me.rank() == Rank(1)) {
    for (int i = 0; i < kTries; ++i) {
      me.await();
      me.send(Rank(0), bytes_of("pong"));
    }
  }
  me.meet();
}

/// Large packets count as unsent until the other side has them, and small ones get past them.
inline void small_pass_large(Player& me, std::size_t large) {
  if (me.size() > 1 && me.rank() == Rank(0)) {
    std::vector<Blob> segments;
    segments.push_back(random_blob(large, 4));
    me.send(Rank(1), bytes_of("large"), std::move(segments));
    me.send(Rank(1), bytes_of("small"));
    me.until([&] { return me.transport().unsent(Rank(1)) == 0; });
  }
  if (me.rank() == Rank(1)) {
    int heads = 0;
    for (int i = 0; i < 2; ++i) heads += me.await().segments.empty() ? 1 : 10;
    EXPECT_EQ(heads, 11);
  }
  me.meet();
}

inline void nobody_is_dead(Player& me) {
  EXPECT_FALSE(me.transport().lost_peer());
  me.meet();
}

/// All traffic above, without one call that `is_collective` says is collective.
inline void no_collective_calls(Player& me, const std::function<bool(std::string_view)>& is_collective) {
  const auto before = me.transport().calls();
  all_to_all(me, 20, 100000);
  receivers_may_send(me, 10);
  wakes(me);
  const auto count_before = [&](const std::string& name) {
    const auto at = std::ranges::find(before, name, [](const auto& call) { return call.first; });
    return at == before.end() ? 0 : at->second;
  };
  for (const auto& [name, count] : me.transport().calls()) {
    EXPECT_TRUE(!is_collective(name) || count == count_before(name)) << name << " was called";
  }
  me.meet();
}

/// Sends what nobody receives, and closes. The network is shut down afterwards.
inline void closes_with_packets_in_flight(Transport& transport, std::size_t largest) {
  for (int to = 0; to < transport.size(); ++to) {
    for (std::size_t i = 0; i < 50; ++i) {
      Packet packet;
      packet.head.resize(i * 100);
      if (i % 5 == 0) packet.segments.push_back(Blob::allocate(i * largest / 50));
      if (i == 7) {
        for (int k = 0; k < 200; ++k) packet.segments.push_back(Blob::allocate(100));
      }
      transport.send(Rank(to), std::move(packet));
    }
  }
  transport.close();
  transport.close();  // twice is no more than once
  transport.wake();   // may come late
}

/// All clauses that leave the network as it was. `largest` is that of a segment.
inline void keeps_contract(const OnEveryRank& on_every_rank, std::size_t largest,
                           double idle_share = kIdleShare) {
  on_every_rank([&](Player& me) { shapes_arrive(me, largest); });
  on_every_rank(misuse_is_refused);
  on_every_rank(self_sends);
  on_every_rank([&](Player& me) { all_to_all(me, 60, largest / 8 + 1); });
  on_every_rank([](Player& me) { receivers_may_send(me, 50); });
  on_every_rank(receivers_may_throw);
  on_every_rank(wakes);
  on_every_rank([&](Player& me) { idles_cheaply(me, idle_share); });
  on_every_rank(sleepers_wake_soon);
  on_every_rank([&](Player& me) { small_pass_large(me, largest); });
  on_every_rank(nobody_is_dead);
}

}  // namespace weft::engine::contract

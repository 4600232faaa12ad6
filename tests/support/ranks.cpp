// Ranks as threads or as processes; delays.
#include "tests/support/ranks.h"

#include <algorithm>
#include <mutex>
#include <random>
#include <thread>

#include "engine/network/loopback_transport.h"
#include "tests/support/mpi_world.h"

namespace weft::testing {
namespace {

using engine::Blob;
using engine::Packet;
using engine::Rank;
using engine::Transport;
using Clock = std::chrono::steady_clock;

class DelayedTransport final : public Transport {
 public:
  DelayedTransport(Transport& below, std::chrono::microseconds longest, unsigned seed)
      : below_(below), longest_(longest), random_(seed * 7919 + static_cast<unsigned>(below.rank().value)) {}

  ~DelayedTransport() override {
    for (Late& packet : late_) below_.keep({packet.from, std::move(packet.head), std::move(packet.segments)});
  }

  Rank rank() const override { return below_.rank(); }
  int size() const override { return below_.size(); }
  void send(Rank to, Packet packet) override { below_.send(to, std::move(packet)); }
  std::size_t unsent(Rank to) const override { return below_.unsent(to); }
  void wake() noexcept override { below_.wake(); }
  std::optional<engine::LostPeer> lost_peer() override { return below_.lost_peer(); }
  bool watches(Rank rank) const override { return below_.watches(rank); }
  void leave(const std::string& why) noexcept override { below_.leave(why); }
  void close() override { below_.close(); }
  void abandon() noexcept override { below_.abandon(); }
  std::uint64_t next_phase() override { return below_.next_phase(); }
  std::uint64_t first_phase() override { return below_.first_phase(); }
  void end_phase() override { below_.end_phase(); }
  void keep(engine::KeptPacket packet) override { below_.keep(std::move(packet)); }
  std::vector<engine::KeptPacket> take_kept() override { return below_.take_kept(); }

  bool poll(const Receive& receive) override {
    bool any = below_.poll([this](Rank from, std::span<const std::byte> head, std::vector<Blob> segments) {
      std::uniform_int_distribution<long> delay(0, longest_.count());
      late_.push_back({Clock::now() + std::chrono::microseconds(delay(random_)),
                       from,
                       {head.begin(), head.end()},
                       std::move(segments)});
    });
    const auto due = std::partition(late_.begin(), late_.end(),
                                    [now = Clock::now()](const Late& packet) { return packet.due > now; });
    std::vector<Late> arrived(std::make_move_iterator(due), std::make_move_iterator(late_.end()));
    late_.erase(due, late_.end());
    std::sort(arrived.begin(), arrived.end(), [](const Late& a, const Late& b) { return a.due < b.due; });
    for (Late& packet : arrived) receive(packet.from, packet.head, std::move(packet.segments));
    return any || !arrived.empty();
  }

  void wait(std::chrono::nanoseconds at_most) override {
    for (const Late& packet : late_) {
      at_most = std::min<std::chrono::nanoseconds>(at_most, packet.due - Clock::now());
    }
    if (at_most.count() > 0) below_.wait(at_most);
  }

 private:
  struct Late {
    Clock::time_point due;
    Rank from;
    std::vector<std::byte> head;
    std::vector<Blob> segments;
  };
  Transport& below_;
  std::chrono::microseconds longest_;
  std::minstd_rand random_;
  std::vector<Late> late_;
};

void on_threads(int ranks, const std::function<void(Transport&)>& function) {
  engine::LoopbackNetwork network(ranks);
  std::vector<std::thread> threads;
  for (int r = 0; r < ranks; ++r) {
    threads.emplace_back([&, r] {
      try {
        function(network.transport(Rank(r)));
      } catch (const std::exception& error) {
        ADD_FAILURE() << "on rank " << r << ": " << error.what();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace

bool is_distributed() { return mpi_world() != nullptr; }

bool is_first_process() { return !is_distributed() || mpi_world()->rank().value == 0; }

std::vector<int> rank_counts() {
  if (is_distributed()) return {mpi_world()->size()};
  return {1, 2, 3, 8};  // 4 are tested as processes
}

void on_ranks(int ranks, const std::function<void(Transport&)>& function) {
  if (!is_distributed()) return on_threads(ranks, function);
  if (ranks != mpi_world()->size()) GTEST_SKIP() << "for " << ranks << " ranks";
  function(*mpi_world());
}

std::unique_ptr<Transport> delayed(Transport& transport, std::chrono::microseconds longest, unsigned seed) {
  return std::make_unique<DelayedTransport>(transport, longest, seed);
}

}  // namespace weft::testing

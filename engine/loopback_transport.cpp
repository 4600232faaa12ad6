// Packets change hands through locked queues.
#include "engine/loopback_transport.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace weft::engine {

struct LoopbackNetwork::Shared {
  explicit Shared(int n) : ranks(n), dead(static_cast<std::size_t>(n)) {}
  int ranks;
  std::vector<std::atomic<bool>> dead;
  std::mutex mutex;
  std::condition_variable all_closed;
  int closed = 0;
};

class LoopbackNetwork::Node final : public Transport {
 public:
  Node(LoopbackNetwork& network, Rank rank) : network_(network), rank_(rank) {}

  Rank rank() const override { return rank_; }
  int size() const override { return network_.shared_->ranks; }

  void send(Rank to, Packet packet) override {
    if (packet.head.size() > kMaxHead) {
      throw TransportError("a packet's head has " + std::to_string(packet.head.size()) + " bytes; " +
                           std::to_string(kMaxHead) + " are allowed");
    }
    if (to.value < 0 || to.value >= size()) {
      throw TransportError("there is no rank " + std::to_string(to.value));
    }
    if (network_.shared_->dead[to.index()]) return;
    network_.nodes_[to.index()]->put(rank_, std::move(packet));
  }

  bool poll(const Receive& receive) override {
    {
      const std::lock_guard lock(mutex_);
      std::swap(arrived_, taken_);
    }
    const bool any = !taken_.empty();
    for (auto& [from, packet] : std::exchange(taken_, {}))
      receive(from, packet.head, std::move(packet.segments));
    return any;
  }

  std::size_t unsent(Rank) const override { return 0; }

  void wait(std::chrono::nanoseconds at_most) override {
    std::unique_lock lock(mutex_);
    arrival_.wait_for(lock, at_most, [this] { return woken_ || !arrived_.empty(); });
    woken_ = false;
  }

  // A lock is not signal safe: a handler's thread could hold it. Good enough for one process under test.
  void wake() noexcept override {
    {
      const std::lock_guard lock(mutex_);
      woken_ = true;
    }
    arrival_.notify_one();
  }

  std::optional<Rank> dead_peer() override {
    for (int r = 0; r < size(); ++r) {
      if (r != rank_.value && network_.shared_->dead[static_cast<std::size_t>(r)]) return Rank(r);
    }
    return std::nullopt;
  }

  void close() override {
    Shared& shared = *network_.shared_;
    std::unique_lock lock(shared.mutex);
    ++shared.closed;
    shared.all_closed.notify_all();
    shared.all_closed.wait(lock, [&] { return shared.closed >= shared.ranks; });
  }

  void abandon() noexcept override {}

 private:
  void put(Rank from, Packet packet) {
    {
      const std::lock_guard lock(mutex_);
      arrived_.emplace_back(from, std::move(packet));
    }
    arrival_.notify_one();
  }

  LoopbackNetwork& network_;
  Rank rank_;
  std::mutex mutex_;
  std::condition_variable arrival_;
  std::vector<std::pair<Rank, Packet>> arrived_;
  std::vector<std::pair<Rank, Packet>> taken_;
  bool woken_ = false;
};

LoopbackNetwork::LoopbackNetwork(int ranks) : shared_(std::make_unique<Shared>(ranks)) {
  for (int r = 0; r < ranks; ++r) nodes_.push_back(std::make_unique<Node>(*this, Rank(r)));
}

LoopbackNetwork::~LoopbackNetwork() = default;

Transport& LoopbackNetwork::transport(Rank rank) { return *nodes_.at(rank.index()); }

void LoopbackNetwork::kill(Rank rank) {
  shared_->dead[rank.index()] = true;
  for (auto& node : nodes_) node->wake();
}

}  // namespace weft::engine

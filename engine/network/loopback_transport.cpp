// Packets change hands through locked queues.
#include "engine/network/loopback_transport.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <utility>

#include "engine/base/sleeper.h"

namespace weft::engine {

struct LoopbackNetwork::Shared {
  Shared(int n, OnAbandon what) : ranks(n), on_abandon(what), dead(static_cast<std::size_t>(n)) {}
  int ranks;
  OnAbandon on_abandon;
  std::vector<std::atomic<bool>> dead;
  std::mutex mutex;
  std::condition_variable closing;
  int closed = 0;
  std::vector<LeaveNotice> notices;

  bool abandoned() const {
    return std::any_of(notices.begin(), notices.end(),
                       [](const LeaveNotice& notice) { return !notice.will_close; });
  }
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
    bool any = false;
    // One at a time: if `receive` throws, the others are still there. No more than are here now: a rank that
    // is flooded must get to sending, too.
    for (std::size_t left = arrived(); left > 0; --left) {
      auto [from, packet] = take();
      receive(from, packet.head, std::move(packet.segments));
      any = true;
    }
    return any;
  }

  std::size_t unsent(Rank) const override { return 0; }
  bool all_sent() const override { return true; }

  void wait(std::chrono::nanoseconds at_most) override {
    bell_.wait(heard_, at_most);
    heard_ = bell_.ticket();
  }

  void wake() noexcept override { bell_.ring(); }

  std::optional<LostPeer> lost_peer() override {
    for (int r = 0; r < size(); ++r) {
      if (r != rank_.value && network_.shared_->dead[static_cast<std::size_t>(r)])
        return LostPeer{Rank(r), "died: its process is gone"};
    }
    const std::lock_guard lock(network_.shared_->mutex);
    return missed_in(phase(), network_.shared_->notices);
  }

  void leave(const std::string& why) noexcept override { depart({rank_, ended_phase(), why, true}); }

  void close() override {
    Shared& shared = *network_.shared_;
    std::unique_lock lock(shared.mutex);
    ++shared.closed;
    shared.closing.notify_all();
    shared.closing.wait(lock, [&] { return shared.closed >= shared.ranks || shared.abandoned(); });
    if (shared.closed < shared.ranks) throw TransportError("a rank has abandoned the network");
  }

  void abandon() noexcept override {
    if (network_.shared_->on_abandon == OnAbandon::exit) std::_Exit(2);
    depart({rank_, ended_phase(), "has abandoned the network", false});
  }

 private:
  void depart(LeaveNotice notice) {
    {
      const std::lock_guard lock(network_.shared_->mutex);
      network_.shared_->notices.push_back(std::move(notice));
    }
    network_.shared_->closing.notify_all();
    for (auto& node : network_.nodes_) node->wake();
  }

  void put(Rank from, Packet packet) {
    {
      const std::lock_guard lock(mutex_);
      arrived_.emplace_back(from, std::move(packet));
    }
    bell_.ring();
  }

  std::size_t arrived() {
    const std::lock_guard lock(mutex_);
    return arrived_.size();
  }

  std::pair<Rank, Packet> take() {
    const std::lock_guard lock(mutex_);
    std::pair<Rank, Packet> next = std::move(arrived_.front());
    arrived_.pop_front();
    return next;
  }

  LoopbackNetwork& network_;
  Rank rank_;
  std::mutex mutex_;
  std::deque<std::pair<Rank, Packet>> arrived_;
  Sleeper bell_;
  Sleeper::Ticket heard_ = 0;  ///< rings before this have been answered
};

LoopbackNetwork::LoopbackNetwork(int ranks, OnAbandon on_abandon)
    : shared_(std::make_unique<Shared>(ranks, on_abandon)) {
  for (int r = 0; r < ranks; ++r) nodes_.push_back(std::make_unique<Node>(*this, Rank(r)));
}

LoopbackNetwork::~LoopbackNetwork() = default;

Transport& LoopbackNetwork::transport(Rank rank) { return *nodes_.at(rank.index()); }

void LoopbackNetwork::kill(Rank rank) {
  shared_->dead[rank.index()] = true;
  for (auto& node : nodes_) node->wake();
}

}  // namespace weft::engine

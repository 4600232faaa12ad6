// Ranks as threads of one process.
#pragma once

#include <algorithm>
#include <barrier>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "partition/peers.h"

namespace weft::support {

/// The numbers of ranks with which everything is tested.
inline constexpr int kNumbersOfRanks[] = {1, 2, 3, 4, 8};

class ThreadsPeers;

/// Runs body(peers) on that many ranks; returns what each has thrown (null: nothing). When one throws, the
/// others' next exchange throws too, so that a test fails instead of hanging.
std::vector<std::exception_ptr> run_ranks_caught(int ranks,
                                                 const std::function<void(partition::Peers&)>& body);
/// Rethrows the first.
void run_ranks(int ranks, const std::function<void(partition::Peers&)>& body);

class ThreadsPeers final : public partition::Peers {
 public:
  struct World {
    explicit World(int ranks)
        : barrier(ranks), mail(static_cast<std::size_t>(ranks) * static_cast<std::size_t>(ranks)) {}
    std::barrier<> barrier;
    std::mutex mutex;
    std::uint64_t last_common_step =
        std::numeric_limits<std::uint64_t>::max();  // the last that all ranks took
    std::vector<partition::Bytes> mail;             // to rank a from rank b at a ranks + b
  };

  ThreadsPeers(World& world, int rank, int ranks) : world_(world), rank_(rank), ranks_(ranks) {}
  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  std::vector<partition::Bytes> exchange(std::vector<partition::Bytes> to_each) override {
    if (to_each.size() != static_cast<std::size_t>(ranks_))
      throw std::logic_error("exchange with a wrong number of ranks");
    for (int r = 0; r < ranks_; ++r) mail(r, rank_) = std::move(to_each[static_cast<std::size_t>(r)]);
    wait();
    std::vector<partition::Bytes> received;
    for (int r = 0; r < ranks_; ++r) received.push_back(std::move(mail(rank_, r)));
    wait();
    return received;
  }

  /// The others are not to wait for this rank any more.
  void fail() {
    {
      const std::lock_guard lock(world_.mutex);
      world_.last_common_step = std::min(world_.last_common_step, step_);
    }
    world_.barrier.arrive_and_drop();
  }

 private:
  partition::Bytes& mail(int to, int from) {
    return world_.mail[static_cast<std::size_t>(to) * static_cast<std::size_t>(ranks_) +
                       static_cast<std::size_t>(from)];
  }
  void wait() {
    world_.barrier.arrive_and_wait();
    const std::lock_guard lock(world_.mutex);
    if (++step_ > world_.last_common_step) throw std::runtime_error("another rank has failed");
  }

  World& world_;
  int rank_, ranks_;
  std::uint64_t step_ = 0;  // times that all have met
};

inline std::vector<std::exception_ptr> run_ranks_caught(int ranks,
                                                        const std::function<void(partition::Peers&)>& body) {
  ThreadsPeers::World world(ranks);
  std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(ranks));
  std::vector<std::thread> threads;
  for (int r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] {
      ThreadsPeers peers(world, r, ranks);
      try {
        body(peers);
      } catch (...) {
        thrown[static_cast<std::size_t>(r)] = std::current_exception();
        peers.fail();
      }
    });
  for (std::thread& thread : threads) thread.join();
  return thrown;
}

inline void run_ranks(int ranks, const std::function<void(partition::Peers&)>& body) {
  for (const std::exception_ptr& e : run_ranks_caught(ranks, body))
    if (e) std::rethrow_exception(e);
}

}  // namespace weft::support

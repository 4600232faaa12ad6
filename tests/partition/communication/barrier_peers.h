// Ranks as threads of the test, which meet at a barrier for every exchange.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// Thrown in ranks that wait for one that has left by an exception.
struct AnotherRankFailed : std::runtime_error {
  AnotherRankFailed() : std::runtime_error("another rank failed") {}
};

/// What the ranks of one run share.
class MeetingRoom {
 public:
  explicit MeetingRoom(int ranks) : mail_(ranks, std::vector<Bytes>(ranks)) {}

  int ranks() const { return static_cast<int>(mail_.size()); }
  std::vector<Bytes> all_to_all(int rank, std::vector<Bytes> to_each) {
    if (to_each.size() != mail_.size()) throw std::logic_error("exchange with a wrong number of ranks");
    for (std::size_t r = 0; r < mail_.size(); ++r) mail_[r][rank] = std::move(to_each[r]);
    meet();
    std::vector<Bytes> arrived = std::move(mail_[rank]);
    mail_[rank] = std::vector<Bytes>(mail_.size());
    meet();  // nobody puts new mail into what others still read
    return arrived;
  }
  void leave() {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    all_here_.notify_all();
  }

 private:
  void meet() {
    std::unique_lock lock(mutex_);
    const std::size_t round = round_;
    if (++waiting_ == mail_.size()) {
      waiting_ = 0;
      ++round_;
      all_here_.notify_all();
    }
    all_here_.wait(lock, [&] { return broken_ || round_ != round; });
    if (round_ == round) throw AnotherRankFailed();
  }

  std::vector<std::vector<Bytes>> mail_;  ///< [to][from]
  std::mutex mutex_;
  std::condition_variable all_here_;
  std::size_t waiting_ = 0, round_ = 0;
  bool broken_ = false;
};

class BarrierPeers final : public Peers {
 public:
  BarrierPeers(MeetingRoom& room, int rank) : room_(room), rank_(rank) {}
  int rank() const override { return rank_; }
  int ranks() const override { return room_.ranks(); }
  std::vector<Bytes> all_to_all(std::vector<Bytes> to_each) override {
    return room_.all_to_all(rank_, std::move(to_each));
  }

 private:
  MeetingRoom& room_;
  int rank_;
};

/// Runs body(peers) on `ranks` threads. Rethrows the exception of the rank that failed first.
inline void run_on_ranks(int ranks, const std::function<void(Peers&)>& body) {
  MeetingRoom room(ranks);
  std::vector<std::exception_ptr> failures(ranks);
  std::vector<std::thread> threads;
  for (int r = 0; r < ranks; ++r) {
    threads.emplace_back([&, r] {
      BarrierPeers peers(room, r);
      try {
        body(peers);
      } catch (const AnotherRankFailed&) {  // the one that did has the reason
      } catch (...) {
        failures[r] = std::current_exception();
        room.leave();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace weft::partition

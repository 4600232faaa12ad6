// Ranks as threads of one process, of which every one's exception counts.
#pragma once

#include <exception>
#include <functional>
#include <thread>
#include <vector>

#include "tests/partition/communication/barrier_peers.h"

namespace weft::support {

/// The numbers of ranks with which everything is tested.
inline constexpr int kNumbersOfRanks[] = {1, 2, 3, 4, 8};

/// Runs body(peers) on that many ranks; returns what each has thrown (null: nothing). When one throws, the
/// others' next exchange throws too, so that a test fails instead of hanging.
inline std::vector<std::exception_ptr> run_ranks_caught(int ranks,
                                                        const std::function<void(partition::Peers&)>& body) {
  partition::MeetingRoom room(ranks);
  std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(ranks));
  std::vector<std::thread> threads;
  for (int r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] {
      partition::BarrierPeers peers(room, r);
      try {
        body(peers);
      } catch (...) {
        thrown[static_cast<std::size_t>(r)] = std::current_exception();
        room.leave();
      }
    });
  for (std::thread& thread : threads) thread.join();
  return thrown;
}

/// Rethrows the first.
inline void run_ranks(int ranks, const std::function<void(partition::Peers&)>& body) {
  for (const std::exception_ptr& e : run_ranks_caught(ranks, body))
    if (e) std::rethrow_exception(e);
}

}  // namespace weft::support

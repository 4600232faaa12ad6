// Which rank has which entries of arrays.
#include "partition/communication/ranges.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::ranges_test {
namespace {

TEST(Ranges, OfSeveralArraysAreThoseOfEachInOneExchange) {
  for (const int ranks : support::kNumbersOfRanks)
    support::run_ranks(ranks, [](Peers& peers) {
      const auto rank = static_cast<std::uint64_t>(peers.rank());
      const std::vector<std::uint64_t> counts = {rank + 1, 0, 7 * rank};
      support::CountingPeers counting(peers);
      const std::vector<Ranges> arrays = Ranges::of_arrays(counting, counts);
      EXPECT_EQ(counting.exchanges, 1u);
      ASSERT_EQ(arrays.size(), counts.size());
      for (std::size_t i = 0; i < counts.size(); ++i) {
        const Ranges alone(peers, counts[i]);
        EXPECT_EQ(arrays[i].total(), alone.total());
        EXPECT_EQ(arrays[i].first(peers.rank()), alone.first(peers.rank()));
        EXPECT_EQ(alone.first(peers.rank() + 1) - alone.first(peers.rank()), counts[i]);
      }
      EXPECT_EQ(arrays[0].rank_of(arrays[0].first(peers.rank())), rank);
    });
}

}  // namespace
}  // namespace weft::partition::ranges_test

// Which rank has which entries of arrays.
#include "partition/communication/ranges.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "partition/communication/even_shares.h"
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

TEST(EvenShares, EachNumberIsInOneAndTheyDifferByOneAtMost) {
  for (const int ranks : {1, 2, 3, 7, 64})
    for (const std::uint64_t total : {1u, 2u, 6u, 7u, 8u, 63u, 64u, 65u, 1000u}) {
      const EvenShares shares(total, ranks);
      std::uint64_t next = 0;
      for (int rank = 0; rank < ranks; ++rank) {
        EXPECT_EQ(shares.first(rank), next);
        const std::uint64_t least = total / static_cast<std::uint64_t>(ranks), count = shares.count(rank);
        EXPECT_TRUE(count == least || count == least + 1) << count << " of " << total << " on " << ranks;
        for (std::uint64_t i = 0; i < count; ++i)
          EXPECT_EQ(shares.rank_of(next + i), static_cast<std::size_t>(rank)) << total << " on " << ranks;
        next += count;
      }
      EXPECT_EQ(next, total);
    }
}

}  // namespace
}  // namespace weft::partition::ranges_test

// Shares along a Morton curve: about equal, also where every rank has points everywhere.
#include "partition/communication/morton_shares.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::morton_shares_test {
namespace {

TEST(MortonShares, OfPointsInAnyOrderAreNoLargerAtTheEnd) {
  constexpr int kRanks = 32, kPoints = 2048;
  std::vector<std::vector<std::uint32_t>> owners(kRanks);
  support::run_ranks(kRanks, [&](Peers& peers) {
    std::mt19937 random(static_cast<unsigned>(peers.rank()));
    std::uniform_real_distribution<double> at(0, 1);
    std::vector<meshing::Point> points(kPoints);
    for (meshing::Point& p : points) p = {at(random), at(random), at(random)};
    owners[static_cast<std::size_t>(peers.rank())] = morton_shares(peers, {points}).owners(points);
  });
  std::vector<double> shares(kRanks, 0);
  for (const auto& of_rank : owners)
    for (const std::uint32_t rank : of_rank) shares[rank] += 1.0 / kPoints;
  EXPECT_NEAR(shares.front(), 1, 0.12);
  EXPECT_NEAR(shares.back(), 1, 0.12);
}

}  // namespace
}  // namespace weft::partition::morton_shares_test

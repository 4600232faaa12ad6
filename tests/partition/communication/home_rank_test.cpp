// Who holds an entity alone or as the lowest, by records that meet at homes.
#include "partition/communication/home_rank.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::home_rank_test {
namespace {

/// What each rank holds, of `entities` different ones: some by several subdomains, some twice by the same.
std::vector<std::vector<Holding<2>>> some_holdings(int ranks, std::uint64_t entities, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<Holding<2>>> of_ranks(static_cast<std::size_t>(ranks));
  for (std::uint64_t e = 0; e < entities; ++e)
    for (std::uint64_t copies = random() % 6; copies > 0; --copies) {
      const std::uint64_t subdomain = random() % 9;
      const EntityKey<2> key{GlobalId(SubdomainId(0), e), GlobalId(SubdomainId(1), e / 2)};
      of_ranks[subdomain % of_ranks.size()].push_back({key, subdomain});
    }
  return of_ranks;
}

TEST(HeldByNoLower, IsWhatTheLowestSubdomainHears) {
  for (const int ranks : support::kNumbersOfRanks)
    for (const std::uint64_t entities : {0, 1, 7, 1000, 20'000}) {
      const auto of_ranks = some_holdings(ranks, entities, static_cast<unsigned>(ranks));
      std::map<EntityKey<2>, std::uint64_t> lowest;
      for (const auto& mine : of_ranks)
        for (const Holding<2>& h : mine) {
          const auto [at, is_new] = lowest.try_emplace(h.key, h.subdomain);
          if (!is_new) at->second = std::min(at->second, h.subdomain);
        }
      support::run_ranks(ranks, [&](Peers& peers) {
        const auto& mine = of_ranks[static_cast<std::size_t>(peers.rank())];
        std::vector<std::uint8_t> expected;
        for (const Holding<2>& h : mine) expected.push_back(h.subdomain == lowest.at(h.key));
        const auto middle = mine.begin() + static_cast<std::ptrdiff_t>(mine.size() / 3);
        EXPECT_EQ(held_by_no_lower<2>(peers, {{mine.begin(), middle}, {}, {middle, mine.end()}}), expected);
      });
    }
}

}  // namespace
}  // namespace weft::partition::home_rank_test

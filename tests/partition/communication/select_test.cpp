// Values at places of what many ranks have, against a plain sort.
#include "partition/communication/select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>

#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::select_test {
namespace {

/// Of different sizes, both signs and, unless `different`, many ties.
std::vector<double> random_values(std::size_t n, bool different) {
  std::mt19937_64 random(n);
  std::vector<double> values(n);
  for (double& value : values) {
    value = std::normal_distribution<double>()(random);
    if (!different) value = std::round(2 * value);
  }
  return values;
}

std::vector<double> share_of(const std::vector<double>& values, const Peers& peers) {
  std::vector<double> mine;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (static_cast<int>(i * i % 7) % peers.ranks() == peers.rank()) mine.push_back(values[i]);
  return mine;
}

TEST(Select, FindsWhatASortFindsInSeveralListsAtOnce) {
  const std::array<std::vector<double>, 3> lists = {random_values(20'000, true), random_values(20'000, false),
                                                    random_values(5, true)};
  const std::array<std::vector<std::uint64_t>, 3> places = {
      std::vector<std::uint64_t>{0, 200, 19'999}, {20, 10'000}, {4}};
  for (const int ranks : support::kNumbersOfRanks)
    support::run_ranks(ranks, [&](Peers& peers) {
      std::array<std::vector<double>, 3> mine;
      std::vector<Selection> wanted;
      for (std::size_t l = 0; l < lists.size(); ++l) {
        mine[l] = share_of(lists[l], peers);
        const std::span<const double> all(mine[l]);
        const std::size_t half = all.size() / 2;
        wanted.push_back({{all.first(half), all.subspan(half)}, places[l]});
      }
      const std::vector<std::vector<double>> found = select_each(peers, wanted);
      for (std::size_t l = 0; l < lists.size(); ++l) {
        std::vector<double> sorted = lists[l];
        std::ranges::sort(sorted);
        ASSERT_EQ(found[l].size(), places[l].size());
        for (std::size_t i = 0; i < places[l].size(); ++i) EXPECT_EQ(found[l][i], sorted[places[l][i]]);
      }
    });
}

TEST(Select, EndsWhenFewAreLeft) {
  support::run_ranks(4, [](Peers& peers) {
    support::CountingPeers counting(peers);
    const std::vector<double> mine = share_of(random_values(20'000, true), peers);
    const std::array<std::uint64_t, 1> place = {5000};
    select(counting, mine, place);
    EXPECT_LE(counting.exchanges, 4u);
  });
}

}  // namespace
}  // namespace weft::partition::select_test

// Distributed cuts against a plain sort of all items.
#include "partition/decompose/ordered_cuts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "partition/communication/reduce.h"
#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::ordered_cuts_test {
namespace {

struct Case {
  std::vector<std::uint64_t> keys, numbers, weights;
  std::vector<std::uint32_t> groups;
  std::vector<std::vector<std::uint32_t>> shares;
};

/// Keys with many ties, weights of many sizes, numbers in no order.
Case random_case(unsigned seed) {
  std::mt19937_64 random(seed);
  Case c;
  const std::size_t n = random() % (seed % 4 ? 400 : 12'000);  // few items are not counted but sent
  const std::uint64_t different_keys = 1 + random() % 100;
  for (std::size_t j = 0, groups = 1 + random() % 5; j < groups; ++j) {
    c.shares.emplace_back(1 + random() % 9);
    for (auto& share : c.shares.back()) share = 1 + static_cast<std::uint32_t>(random() % 4);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint64_t key = random() % different_keys;
    c.keys.push_back(seed % 2 ? key : key * (std::numeric_limits<std::uint64_t>::max() / different_keys));
    c.weights.push_back(1 + random() % (std::uint64_t{1} << random() % 40));
    c.groups.push_back(static_cast<std::uint32_t>(random() % c.shares.size()));
  }
  c.numbers.resize(n);
  std::iota(c.numbers.begin(), c.numbers.end(), 1000);
  std::shuffle(c.numbers.begin(), c.numbers.end(), random);
  return c;
}

/// The definition: an item goes left of all cuts that its middle does not pass.
std::vector<std::uint32_t> expected_parts(const Case& c) {
  std::vector<std::size_t> order(c.keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(c.keys[a], c.numbers[a]) < std::pair(c.keys[b], c.numbers[b]);
  });
  std::vector<std::uint32_t> parts(c.keys.size());
  std::uint32_t offset = 0;
  for (std::uint32_t g = 0; g < c.shares.size(); ++g) {
    std::uint64_t total = 0, before = 0;
    for (std::size_t i = 0; i < c.keys.size(); ++i) total += c.groups[i] == g ? c.weights[i] : 0;
    const std::uint64_t whole = std::accumulate(c.shares[g].begin(), c.shares[g].end(), std::uint64_t{0});
    for (const std::size_t i : order) {
      if (c.groups[i] != g) continue;
      std::uint32_t part = 0;
      std::uint64_t shares = c.shares[g][0];
      while (part + 1 < c.shares[g].size() && 2 * before + c.weights[i] > 2 * (total * shares / whole))
        shares += c.shares[g][++part];
      parts[i] = offset + part;
      before += c.weights[i];
    }
    offset += static_cast<std::uint32_t>(c.shares[g].size());
  }
  return parts;
}

TEST(OrderedCuts, AreThoseOfASortOfAllItems) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const Case c = random_case(seed);
    const std::vector<std::uint32_t> expected = expected_parts(c);
    for (const int ranks : support::kNumbersOfRanks) {
      std::vector<std::uint32_t> parts(c.keys.size(), 999);
      support::run_ranks(ranks, [&](Peers& peers) {
        // Every rank's items in pieces from all over, some ranks without any.
        std::vector<std::size_t> mine;
        for (std::size_t i = 0; i < c.keys.size(); ++i)
          if (static_cast<int>(i * i * 7 % 11) % peers.ranks() == peers.rank()) mine.push_back(i);
        Case local;
        for (const std::size_t i : mine) {
          local.keys.push_back(c.keys[i]), local.numbers.push_back(c.numbers[i]);
          local.weights.push_back(c.weights[i]), local.groups.push_back(c.groups[i]);
        }
        const auto found =
            cut_groups(peers, {local.keys, local.numbers, local.weights}, local.groups, c.shares);
        for (std::size_t k = 0; k < mine.size(); ++k) parts[mine[k]] = found[k];
      });
      ASSERT_EQ(parts, expected) << "seed " << seed << ", ranks " << ranks;
    }
  }
}

// As tets that reach equally far, since they have their farthest vertex in common.
TEST(OrderedCuts, AreFoundInFewExchangesAmongEqualKeys) {
  support::run_ranks(4, [](Peers& peers) {
    std::mt19937_64 random(static_cast<unsigned>(peers.rank()));
    constexpr std::size_t kItems = 50'000;
    std::vector<std::uint64_t> keys(kItems), numbers(kItems), weights(kItems, 1);
    for (std::uint64_t& key : keys)
      key = ordered_key(std::round(2000 * std::normal_distribution<double>()(random)) / 700);
    std::iota(numbers.begin(), numbers.end(), kItems * static_cast<std::uint64_t>(peers.rank()));
    support::CountingPeers counting(peers);
    cut_groups(counting, {keys, numbers, weights}, std::vector<std::uint32_t>(kItems, 0), {{1, 1}});
    EXPECT_LE(counting.exchanges, 5u);
    EXPECT_LE(counting.most, 100'000u);
  });
}

TEST(OrderedCuts, HandleTheGreatestTotal) {
  SelfPeers alone;
  const std::vector<std::uint64_t> keys{3, 2, 1, 0}, numbers{0, 1, 2, 3};
  const std::vector<std::uint64_t> weights(4, (std::uint64_t{1} << 60) - 1);
  const std::vector<std::uint32_t> groups(4, 0);
  EXPECT_EQ(cut_groups(alone, {keys, numbers, weights}, groups, {{1, 1, 1, 1}}),
            (std::vector<std::uint32_t>{3, 2, 1, 0}));
}

TEST(OrderedCuts, KeysOrderAsNumbersDo) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<double> ascending{-kInfinity, -1e300, -1, -1e-300, 0, 1e-300, 1, 1e300, kInfinity};
  for (std::size_t i = 1; i < ascending.size(); ++i)
    EXPECT_LT(ordered_key(ascending[i - 1]), ordered_key(ascending[i]));
  EXPECT_EQ(ordered_key(-0.0), ordered_key(0.0));
}

TEST(OrderedCuts, IntegerWeightsKeepProportions) {
  SelfPeers alone;
  const std::vector<double> work{1e-3, 2e-3, 1, 0, -5, std::nan("")};
  const auto weights = integer_weights(alone, work);
  EXPECT_NEAR(static_cast<double>(weights[1]) / static_cast<double>(weights[0]), 2, 1e-12);
  EXPECT_NEAR(static_cast<double>(weights[2]) / static_cast<double>(weights[0]), 1000, 1e-9);
  for (int i : {3, 4, 5}) EXPECT_EQ(weights[i], 1u);
}

TEST(OrderedCuts, IntegerWeightsSurviveAnySpread) {
  SelfPeers alone;
  const std::vector<double> spread{1e-300, 1e300, std::numeric_limits<double>::infinity()};
  const auto weights = integer_weights(alone, spread);
  EXPECT_EQ(weights[0], 1u);
  EXPECT_GT(weights[2], weights[1]);
  EXPECT_LT(weights[0] + weights[1] + weights[2], std::uint64_t{1} << 62);
  EXPECT_EQ(integer_weights(alone, std::vector<double>(3, 0)), std::vector<std::uint64_t>(3, 1));
}

TEST(Reduce, OrderedSumIsExactAndTheSameForAllRanks) {
  std::mt19937_64 random(5);
  std::vector<double> values(1000);
  long double exact = 0;
  for (double& value : values) {
    value =
        std::ldexp(std::uniform_real_distribution<double>(0.5, 1)(random), static_cast<int>(random() % 40));
    exact += value;
  }
  std::vector<double> sums;
  for (const int ranks : support::kNumbersOfRanks)
    support::run_ranks(ranks, [&](Peers& peers) {
      std::vector<double> mine;
      for (std::size_t i = 0; i < values.size(); ++i)
        if (static_cast<int>(i % 13) % peers.ranks() == peers.rank()) mine.push_back(values[i]);
      const double found = ordered_sum(peers, mine);
      if (peers.rank() == 0) sums.push_back(found);
    });
  for (const double found : sums) EXPECT_EQ(found, sums[0]);
  EXPECT_NEAR(sums[0], static_cast<double>(exact), 1e-14 * static_cast<double>(exact));
  SelfPeers alone;
  EXPECT_EQ(ordered_sum(alone, std::vector<double>(3, 0)), 0);
}

}  // namespace
}  // namespace weft::partition::ordered_cuts_test

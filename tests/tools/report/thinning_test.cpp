// What is left of triangles is what joining them one by one leaves, and it is known what stands for which.
#include "tools/report/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace weft::report::thinning_test {
namespace {

using meshing::Box;
using Facet = std::array<Corner, 3>;

constexpr Box kBox{{-1, 0, 2}, {1, 1, 4}};

/// A wavy sheet of `n` x `n` squares, two triangles each; with `shared` points, or each with its own.
Triangles sheet(std::uint32_t n, unsigned seed, bool shared) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> shake(-0.2F, 0.2F);
  Triangles triangles;
  const auto side = static_cast<float>(n);
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) {
      const float u = (static_cast<float>(i) + shake(random)) / side, v = static_cast<float>(j) / side;
      triangles.points.push_back({2 * u - 1, std::clamp(v, 0.0F, 1.0F), 3 + std::sin(5 * u) * v});
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      triangles.corners.push_back({a, b, a + 1});
      triangles.corners.push_back({b + 1, a + 1, b});
    }
  std::ranges::shuffle(triangles.corners, random);
  if (shared) return triangles;
  Triangles apart;
  for (std::size_t t = 0; t < triangles.corners.size(); ++t) apart.add(triangles.at(t));
  return apart;
}

/// One grid, in the plainest way: `stands_for` gets the old triangles of each new one.
std::vector<Facet> joined(const std::vector<Facet>& facets, double cell,
                          std::vector<std::vector<std::uint32_t>>& stands_for) {
  std::map<std::array<double, 3>, Corner> first_in_cell;
  std::map<std::array<Corner, 3>, std::size_t> known;
  std::vector<Facet> left;
  std::vector<std::vector<std::uint32_t>> merged;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    Facet facet = facets[f];
    for (Corner& c : facet) {
      const std::array<double, 3> key = {std::floor((c[0] - kBox.lo.x) * (1 / cell)),
                                         std::floor((c[1] - kBox.lo.y) * (1 / cell)),
                                         std::floor((c[2] - kBox.lo.z) * (1 / cell))};
      c = first_in_cell.try_emplace(key, c).first->second;
    }
    if (facet[0] == facet[1] || facet[1] == facet[2] || facet[2] == facet[0]) continue;
    Facet key = facet;
    std::ranges::sort(key);
    const std::size_t place = known.try_emplace(key, left.size()).first->second;
    if (place == left.size()) left.push_back(facet), merged.emplace_back();
    merged[place].insert(merged[place].end(), stands_for[f].begin(), stands_for[f].end());
  }
  stands_for = merged;
  return left;
}

void check(const Triangles& triangles, std::size_t most) {
  std::vector<Facet> expected;
  std::vector<std::vector<std::uint32_t>> stands_for;
  for (std::uint32_t t = 0; t < triangles.corners.size(); ++t)
    expected.push_back(triangles.at(t)), stands_for.push_back({t});
  for (double cell = 2.0 / 1024; expected.size() > most;) {
    expected = joined(expected, cell, stands_for);
    cell *= std::max(1.1, std::sqrt(static_cast<double>(expected.size()) / static_cast<double>(most)));
  }
  const Thinning thinning = thinned_out(triangles, kBox, most);
  EXPECT_EQ(thinning.thinned, triangles.corners.size() > most);
  ASSERT_EQ(thinning.left.corners.size(), expected.size());
  for (std::size_t t = 0; t < expected.size(); ++t) EXPECT_EQ(thinning.left.at(t), expected[t]);
  std::vector<std::vector<std::uint32_t>> standing(expected.size());
  ASSERT_EQ(thinning.kept.size(), thinning.in_left.size());
  for (std::size_t i = 0; i < thinning.kept.size(); ++i)
    standing.at(thinning.in_left[i]).push_back(thinning.kept[i]);
  for (std::vector<std::uint32_t>& of_one : stands_for) std::ranges::sort(of_one);
  EXPECT_EQ(standing, stands_for);
  EXPECT_TRUE(std::ranges::is_sorted(thinning.kept));
}

TEST(Thinning, LeavesWhatJoiningOneByOneLeaves) {
  for (const std::size_t most : {2000u, 700u, 150u, 20u})
    for (const bool shared : {true, false}) check(sheet(40, 7, shared), most);
}

TEST(Thinning, LeavesTheSameWhetherPointsAreSharedOrNot) {
  const Thinning shared = thinned_out(sheet(30, 2, true), kBox, 300);
  const Thinning apart = thinned_out(sheet(30, 2, false), kBox, 300);
  EXPECT_EQ(shared.kept, apart.kept);
  EXPECT_EQ(shared.in_left, apart.in_left);
}

TEST(Thinning, LeavesWhatIsFewAsItIs) {
  check(sheet(5, 3, true), 50);
  check({}, 0);
}

TEST(Thinning, MayLeaveNothing) { check(sheet(5, 3, true), 0); }

}  // namespace
}  // namespace weft::report::thinning_test

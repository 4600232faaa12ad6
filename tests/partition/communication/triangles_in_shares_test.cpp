// The closest of triangles in shares: the bits of all of them on one rank, and no rank gets them all.
#include "partition/communication/triangles_in_shares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::triangles_in_shares_test {
namespace {

using meshing::Point;
using Triangle = TrianglesInShares::Triangle;
using Found = TrianglesInShares::Found;

/// On a lattice or anywhere: of the first kind many are equally near.
Point some_point(bool lattice, double reach, std::mt19937& random) {
  std::uniform_real_distribution<double> anywhere(-reach, reach);
  Point p{anywhere(random), anywhere(random), anywhere(random)};
  if (lattice)
    for (int i = 0; i < 3; ++i) p[i] = std::round(4 * p[i]) / 3;
  return p;
}

std::vector<Triangle> some_triangles(std::uint64_t count, bool lattice, std::mt19937& random) {
  std::vector<Triangle> triangles;
  for (std::uint64_t number = 0; number < count; ++number) {
    const Point a = some_point(lattice, 1, random);
    triangles.push_back(
        {number, {a, a + 0.3 * some_point(lattice, 1, random), a + 0.3 * some_point(lattice, 1, random)}});
  }
  return triangles;
}

/// Which ranks of so many have the i-th, or ask for it.
using Deal = std::function<bool(std::size_t i, int rank, int ranks)>;

struct NamedDeal {
  const char* name;
  Deal deal;
};

const NamedDeal kDeals[] = {
    {"one by one", [](std::size_t i, int rank, int ranks) { return static_cast<int>(i) % ranks == rank; }},
    {"all on the last", [](std::size_t, int rank, int ranks) { return rank == ranks - 1; }},
    {"none on the last",
     [](std::size_t i, int rank, int ranks) {
       return ranks == 1 || (rank < ranks - 1 && static_cast<int>(i) % (ranks - 1) == rank);
     }},
    {"on all", [](std::size_t, int, int) { return true; }},
    {"on several", [](std::size_t i, int rank, int ranks) {
       return static_cast<int>(i) % ranks == rank || static_cast<int>(i) / 3 % ranks == rank;
     }}};

template <class T>
std::vector<T> dealt(const std::vector<T>& all, const Deal& deal, const Peers& peers) {
  std::vector<T> mine;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (deal(i, peers.rank(), peers.ranks())) mine.push_back(all[i]);
  return mine;
}

void expect_those_of_all(const std::vector<Triangle>& triangles, const std::vector<Point>& points,
                         const TrianglesInShares::Limits& limits) {
  const meshing::ClosestTriangles whole(triangles);
  for (const int ranks : support::kNumbersOfRanks)
    for (const NamedDeal& have : kDeals)
      for (const NamedDeal& want : kDeals) {
        SCOPED_TRACE(std::to_string(ranks) + " ranks, triangles " + have.name + ", points " + want.name);
        support::run_ranks(ranks, [&](Peers& peers) {
          const TrianglesInShares shares(peers, dealt(triangles, have.deal, peers), limits);
          const std::vector<Point> mine = dealt(points, want.deal, peers);
          const std::vector<Found> found = shares.closest(mine);
          ASSERT_EQ(found.size(), mine.size());
          for (std::size_t i = 0; i < mine.size(); ++i) {
            const Found expected = whole.closest(mine[i]);
            EXPECT_EQ(found[i].distance2, expected.distance2);
            EXPECT_EQ(found[i].number, expected.number);
            EXPECT_EQ(found[i].way, expected.way);
          }
        });
      }
}

TEST(TrianglesInShares, FindTheClosestOfAll) {
  std::mt19937 random(11);
  for (const bool lattice : {false, true}) {
    const std::vector<Triangle> triangles = some_triangles(150, lattice, random);
    std::vector<Point> points;
    for (int i = 0; i < 120; ++i) points.push_back(some_point(i % 2 == 0, i % 3 == 0 ? 20 : 1.5, random));
    for (const Triangle& triangle : triangles) points.push_back(triangle.corners[0]);
    for (const TrianglesInShares::Limits limits :
         {TrianglesInShares::Limits{0, 1 << 20}, {0, 400}, {800, 400}})
      expect_those_of_all(triangles, points, limits);
  }
}

TEST(TrianglesInShares, OfOneTriangleAndOfNone) {
  std::mt19937 random(2);
  const std::vector<Point> points{{0, 0, 0}, {1, 2, 3}};
  for (const std::uint64_t few : {0, 10}) {
    expect_those_of_all(some_triangles(1, false, random), points, {few, 1});
    expect_those_of_all({}, points, {few, 1});
    expect_those_of_all(some_triangles(5, false, random), {}, {few, 1});
  }
}

TEST(TrianglesInShares, SendPointsWhereTheyAreNeeded) {
  constexpr int kRanks = 8, kCells = 24;  // of a strip
  std::uint64_t number = 0;
  std::vector<std::vector<Triangle>> strips(kRanks);
  std::vector<std::vector<Point>> points(kRanks);
  for (int i = 0; i < kRanks * kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const auto at = [](int x, int y) { return Point{static_cast<double>(x), static_cast<double>(y), 0}; };
      const Point a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      strips[i / kCells].push_back({number++, {a, b, c}});
      strips[i / kCells].push_back({number++, {a, c, d}});
      points[i / kCells].push_back({i + 0.3, j + 0.4, 0.1 * j});
    }
  support::run_ranks(kRanks, [&](Peers& peers) {
    support::CountingPeers counting(peers);
    const TrianglesInShares shares(counting, strips[static_cast<std::size_t>(peers.rank())]);
    for (const Found& found : shares.closest(points[static_cast<std::size_t>(peers.rank())]))
      EXPECT_EQ(found.number / (2 * kCells * kCells), static_cast<std::uint64_t>(peers.rank()));
    EXPECT_LT(counting.most, number * sizeof(Triangle) / 4) << "as if all triangles were sent";
  });
}

}  // namespace
}  // namespace weft::partition::triangles_in_shares_test

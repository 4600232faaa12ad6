// Points of pieces on ranks have the numbers and values of the merged mesh.
#include "partition/slice/joined_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <random>

#include "meshing/base/error.h"
#include "meshing/io/files/merge_pieces.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"

namespace weft::partition::joined_points_test {
namespace {

using meshing::MeshPiece;
using meshing::Point;

/// Pieces that draw some of 40 points each; copies differ in what they should not. `ids`: of the 40.
std::vector<MeshPiece> some_pieces(const std::vector<std::int64_t>& ids) {
  std::mt19937 random(5);
  std::vector<MeshPiece> pieces(6);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    std::vector<std::uint32_t> points(40);
    std::iota(points.begin(), points.end(), 0u);
    std::ranges::shuffle(points, random);
    points.resize(p == 2 ? 0 : p == 5 ? 40 : 15);  // one has none, one all
    meshing::MeshContents& contents = pieces[p].contents;
    for (const std::uint32_t v : points) {
      const double zero = random() % 2 == 0 ? 0.0 : -0.0;
      contents.mesh.points.push_back({v / 3.0, zero, 1.0 * (v % 7)});
      contents.mesh.point_refs.push_back(static_cast<std::int32_t>(random() % 100));
      if (!ids.empty()) pieces[p].global_ids.push_back(ids[v]);
    }
    contents.fields = {points.size(), {{meshing::Field::Kind::scalar, {}, "f"}}};
    for (std::size_t i = 0; i < points.size(); ++i)
      contents.fields.fields[0].values.push_back(static_cast<double>(random() % 1000));
    // Tets tell which number each copy gets.
    for (std::uint32_t i = 0; i < points.size(); ++i) contents.mesh.tets.push_back({i, i, i, i});
    contents.complete();
  }
  return pieces;
}

/// The bytes of coordinates count: -0 is not 0.
bool same_bits(const Point& a, const Point& b) {
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

void expect_as_merged(const std::vector<std::int64_t>& ids) {
  const std::vector<MeshPiece> pieces = some_pieces(ids);
  const bool by_ids = !ids.empty();
  const meshing::MeshContents merged = meshing::merge_pieces(pieces);
  std::vector<Point> points;
  std::vector<std::int32_t> refs;
  std::vector<double> values;
  std::vector<std::int64_t> copy_ids;
  for (const MeshPiece& piece : pieces) {
    const meshing::MeshData& mesh = piece.contents.mesh;
    points.insert(points.end(), mesh.points.begin(), mesh.points.end());
    refs.insert(refs.end(), mesh.point_refs.begin(), mesh.point_refs.end());
    copy_ids.insert(copy_ids.end(), piece.global_ids.begin(), piece.global_ids.end());
    const auto& field = piece.contents.fields.fields[0].values;
    values.insert(values.end(), field.begin(), field.end());
  }
  if (!by_ids)
    for (Point& p : points) p.y += 0.0;
  for (const int ranks : support::kNumbersOfRanks)
    for (const unsigned seed : {0u, 3u}) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, shares " + std::to_string(seed));
      support::run_ranks(ranks, [&](Peers& peers) {
        const auto mine = [&]<class T>(const std::vector<T>& all) {
          const auto at = [&](int r) {
            return all.begin() +
                   static_cast<std::ptrdiff_t>(support::share_begin(all.size(), r, ranks, seed));
          };
          return std::vector<T>(at(peers.rank()), at(peers.rank() + 1));
        };
        const JoinedPoints joined(peers, mine(points), mine(copy_ids), by_ids);
        ASSERT_EQ(joined.total(), merged.mesh.points.size());
        std::vector<std::uint64_t> copies(points.size());
        std::iota(copies.begin(), copies.end(), std::uint64_t{0});
        copies = mine(copies);
        const std::vector<std::uint32_t> numbers = joined.numbers_of(peers, copies);
        for (std::size_t i = 0; i < copies.size(); ++i) EXPECT_EQ(numbers[i], merged.mesh.tets[copies[i]][0]);

        const std::uint64_t first = support::share_begin(joined.total(), peers.rank(), ranks, seed);
        const Ranges shares(peers,
                            support::share_begin(joined.total(), peers.rank() + 1, ranks, seed) - first);
        const auto dealt = joined.deal(peers, mine(points), JoinedPoints::Copy::first, shares);
        const auto dealt_refs = joined.deal(peers, mine(refs), JoinedPoints::Copy::last, shares);
        const auto dealt_values = joined.deal(peers, mine(values), JoinedPoints::Copy::last, shares);
        for (std::size_t i = 0; i < dealt.size(); ++i) {
          EXPECT_TRUE(same_bits(dealt[i], merged.mesh.points[first + i]));
          EXPECT_EQ(dealt_refs[i], merged.mesh.point_refs[first + i]);
          EXPECT_EQ(dealt_values[i], merged.fields.fields[0].values[first + i]);
        }
      });
    }
}

TEST(JoinedPoints, ByPlace) { expect_as_merged({}); }

TEST(JoinedPoints, ByIdsThatAreTheOrderOfThePoints) {
  std::vector<std::int64_t> ids(40);
  std::iota(ids.begin(), ids.end(), 0);
  std::ranges::shuffle(ids, std::mt19937(1));
  expect_as_merged(ids);
}

TEST(JoinedPoints, ByIdsThatAreAnyNumbers) {
  std::vector<std::int64_t> ids(40);
  std::iota(ids.begin(), ids.end(), 0);
  ids[7] = 40;
  expect_as_merged(ids);
  ids[7] = -5;
  expect_as_merged(ids);
}

TEST(JoinedPoints, OfOnePieceKeepTheirOrder) {
  support::run_ranks(3, [](Peers& peers) {
    const JoinedPoints joined(peers, static_cast<std::uint64_t>(peers.rank()));  // 0, 1 and 2 points
    EXPECT_EQ(joined.total(), 3u);
    EXPECT_EQ(joined.numbers_of(peers, {0, 2}), (std::vector<std::uint32_t>{0, 2}));
  });
}

TEST(JoinedPoints, OfOnePieceAreRefusedWhere32BitsCannotNumberThem) {
  support::run_ranks(2, [](Peers& peers) {
    const std::uint64_t half = std::uint64_t{1} << 31;
    EXPECT_THAT([&] { JoinedPoints(peers, half); }, testing::ThrowsMessage<meshing::InputError>(
                                                        testing::HasSubstr("4294967296 vertices exceed")));
  });
}

}  // namespace
}  // namespace weft::partition::joined_points_test

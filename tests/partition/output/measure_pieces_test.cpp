// Measures of pieces are those of the merged mesh, for any ranks and cuts.
#include "partition/output/measure_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <numeric>
#include <optional>

#include "partition/communication/select.h"
#include "partition/output/numbering.h"
#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/output/piece_support.h"

namespace weft::partition::measure_pieces_test {
namespace {

using meshing::Histogram;
using meshing::Measures;

void expect_same(const Histogram& a, const Histogram& b) {
  EXPECT_EQ(a.counts, b.counts);
  EXPECT_EQ(a.below, b.below);
  EXPECT_EQ(a.above, b.above);
}

/// Counts, shares and qualities exactly; sums, and lengths, which may be taken from the other end, to
/// rounding.
void expect_same(const Measures& a, const Measures& b) {
  for (const auto member :
       {&Measures::num_vertices, &Measures::num_tets, &Measures::num_edges, &Measures::num_triangles})
    EXPECT_EQ(a.*member, b.*member);
  for (const auto member :
       {&Measures::quality_min, &Measures::quality_q01, &Measures::quality_q001, &Measures::quality_below_01,
        &Measures::quality_below_02, &Measures::quality_above_08, &Measures::edges_unit,
        &Measures::edges_short, &Measures::edges_long})
    EXPECT_EQ(a.*member, b.*member);
  for (const auto member : {&Measures::volume, &Measures::complexity, &Measures::quality_mean,
                            &Measures::length_mean, &Measures::length_min, &Measures::length_max})
    EXPECT_NEAR(a.*member, b.*member, 1e-13 * std::abs(b.*member));
  expect_same(a.quality, b.quality);
  expect_same(a.quality_log, b.quality_log);
  expect_same(a.length, b.length);
  expect_same(a.length_log, b.length_log);
}

/// Bit by bit.
void expect_identical(const Measures& a, const Measures& b) {
  expect_same(a, b);
  for (const auto member : {&Measures::volume, &Measures::complexity, &Measures::quality_mean,
                            &Measures::length_mean, &Measures::length_min, &Measures::length_max})
    EXPECT_EQ(a.*member, b.*member);
}

using Flag = std::function<bool(const MeshPiece&, std::size_t)>;

/// What all ranks agree on; `flag` may be empty.
Measures measure_on(int ranks, const std::vector<MeshPiece>& pieces, const Flag& flag) {
  const auto hands = deal(pieces, ranks, static_cast<unsigned>(ranks));
  std::mutex mutex;
  std::vector<Measures> results;
  run_on_ranks(ranks, [&](Peers& peers) {
    const std::vector<MeshPiece>& mine = hands[peers.rank()];
    VertexFlags flags;
    for (const MeshPiece& piece : mine) {
      flags.emplace_back();
      for (std::size_t v = 0; flag && v < piece.ids.size(); ++v) flags.back().push_back(flag(piece, v));
    }
    const Measures m = flag ? measure_pieces(peers, mine, flags).part : measure_pieces(peers, mine);
    const std::lock_guard lock(mutex);
    results.push_back(m);
  });
  EXPECT_EQ(results.size(), static_cast<std::size_t>(ranks));
  for (const Measures& m : results) expect_identical(m, results[0]);
  return results[0];
}

TEST(MeasurePieces, GivesTheMeasuresOfTheMergedMesh) {
  for (unsigned seed = 0; seed < 21; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    const Measures expected = meshing::measure(cut.whole.mesh, cut.whole.log_metrics);
    std::optional<Measures> first;
    for (const int ranks : kRankCounts) {
      const Measures m = measure_on(ranks, cut.pieces, {});
      if (!first) first = m;
      expect_same(m, expected);
      expect_identical(m, *first);
    }
  }
}

/// The tets of a mesh with a flagged vertex, their vertices, and the triangles with one.
MergedMesh part_of(const MergedMesh& whole, const std::vector<bool>& flags) {
  MergedMesh part;
  std::map<std::uint32_t, std::uint32_t> numbers;
  const auto flagged = [&](const auto& entity) {
    return std::any_of(entity.begin(), entity.end(), [&](std::uint32_t v) { return flags[v]; });
  };
  for (auto tet : whole.mesh.tets) {
    if (!flagged(tet)) continue;
    for (std::uint32_t& v : tet) {
      const auto [it, is_new] = numbers.try_emplace(v, static_cast<std::uint32_t>(numbers.size()));
      if (is_new) {
        part.mesh.points.push_back(whole.mesh.points[v]);
        part.log_metrics.push_back(whole.log_metrics[v]);
      }
      v = it->second;
    }
    part.mesh.tets.push_back(tet);
  }
  for (auto triangle : whole.mesh.triangles) {
    if (!flagged(triangle)) continue;
    for (std::uint32_t& v : triangle) v = numbers.at(v);
    part.mesh.triangles.push_back(triangle);
  }
  return part;
}

TEST(MeasurePieces, OfFlaggedVerticesAreThoseOfTheirTetsAlone) {
  for (unsigned seed = 0; seed < 21; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    // Some vertices of the interface: the numbers of the input are in the ids.
    std::vector<bool> flags(cut.whole.mesh.points.size());
    for (const MeshPiece& piece : cut.pieces)
      for (const auto& shared : piece.shared)
        flags[piece.ids[shared.vertex].local()] = piece.ids[shared.vertex].local() % 3 != seed % 3;
    const MergedMesh part = part_of(cut.whole, flags);
    const Measures expected = meshing::measure(part.mesh, part.log_metrics);
    for (const int ranks : kRankCounts) {
      const auto flag = [&](const MeshPiece& piece, std::size_t v) { return flags[piece.ids[v].local()]; };
      expect_same(measure_on(ranks, cut.pieces, flag), expected);
    }
  }
}

TEST(MeasurePieces, TakesAsFewExchangesHoweverManyKindsOfEntitiesAreShared) {
  const CutMesh cut = random_cut(6);
  const auto hands = deal(cut.pieces, 4);
  run_on_ranks(4, [&](Peers& peers) {
    support::CountingPeers numbered(peers), measured(peers);
    const std::vector<MeshPiece>& mine = hands[static_cast<std::size_t>(peers.rank())];
    const Numbering numbering = number_pieces(numbered, mine);
    EXPECT_LE(numbered.exchanges, 7u);
    VertexFlags flags;
    for (const MeshPiece& piece : mine) flags.emplace_back(piece.mesh.points.size(), 1);
    measure_pieces(measured, mine, flags, &numbering);
    EXPECT_LE(measured.exchanges, 8u);
  });
}

TEST(MeasurePieces, OfNoTetsAreZero) {
  const Measures m = measure_on(3, std::vector<MeshPiece>(1), {});
  EXPECT_EQ(m.num_tets, 0u);
  EXPECT_EQ(m.quality_min, 0);
  EXPECT_EQ(measure_on(2, random_cut(3).pieces, [](const auto&, auto) { return false; }).num_vertices, 0u);
}

TEST(Select, FindsEveryPlaceOfValuesOnManyRanks) {
  std::mt19937 random(7);
  std::vector<double> values = {0, -1, 1, 1e-300, -1e300, 0.5, 0.5, 0.5, -1e-310};
  for (int i = 0; i < 40; ++i) values.push_back(std::ldexp(static_cast<double>(random() % 9) - 4, i - 20));
  std::shuffle(values.begin(), values.end(), random);
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (const int ranks : kRankCounts) {
    run_on_ranks(ranks, [&](Peers& peers) {
      std::vector<double> mine;  // the last rank has none
      for (std::size_t i = 0; i < values.size(); ++i)
        if (static_cast<int>(i) % std::max(ranks - 1, 1) == peers.rank()) mine.push_back(values[i]);
      std::vector<std::uint64_t> places(sorted.size());
      std::iota(places.begin(), places.end(), 0);
      EXPECT_EQ(select(peers, mine, places), sorted);
    });
  }
}

TEST(Select, FindsPlacesAmongValuesThatBeginAlike) {
  std::mt19937 random(3);
  for (const double share_alike : {0.0, 0.3, 0.95}) {
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<double> values;
    for (int i = 0; i < 2000; ++i)
      values.push_back(share(random) < share_alike ? 0.75 : 0.5 + share(random) / 2);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const std::vector<std::uint64_t> places = {0, 1, 19, 300, 1999};
    std::vector<double> expected;
    for (const std::uint64_t place : places) expected.push_back(sorted[place]);
    run_on_ranks(3, [&](Peers& peers) {
      const auto begin = values.begin() + 400 * peers.rank() * peers.rank();  // the first has few
      const auto end =
          peers.rank() == 2 ? values.end() : values.begin() + 400 * (peers.rank() + 1) * (peers.rank() + 1);
      EXPECT_EQ(select(peers, std::vector(begin, end), places), expected);
    });
  }
}

}  // namespace
}  // namespace weft::partition::measure_pieces_test

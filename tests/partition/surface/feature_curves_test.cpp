// Curves in shares are those that the features of all ranks together form.
#include "partition/surface/feature_curves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/at_home.h"
#include "partition/communication/morton_shares.h"
#include "partition/surface/joined_chains.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/support/repetitions.h"

namespace weft::partition::feature_curves_test {
namespace {

using meshing::FoundFeature;
using meshing::Point;

/// Chains at random, of one edge up to `longest`: open ones between corners, closed ones with a corner and
/// without; some straight. Vertices are numbered in no order; features are in the order of their vertices.
class Chains {
 public:
  Chains(unsigned seed, std::uint32_t chains, std::uint32_t longest) : random_(seed) {
    for (std::uint32_t c = 0; c < chains; ++c) add(c, 1 + static_cast<std::uint32_t>(random_()) % longest);
    number_vertices();
  }
  const std::vector<FoundFeature>& features() const { return features_; }
  std::uint32_t num_vertices() const { return num_vertices_; }

 private:
  void add(std::uint32_t chain, std::uint32_t edges) {
    const unsigned kind = static_cast<unsigned>(random_()) % 4;  // open, open and straight, closed twice
    if (kind >= 2) edges = std::max(edges, 3u);
    const std::uint32_t first = num_vertices_;
    const auto point = [&](std::uint32_t i) {
      const double along = kind >= 2 ? 6.28 * i / edges : 0.1 * i, height = 0.37 * chain;
      return kind == 1 ? Point{along, 1, height} : Point{std::cos(along), std::sin(along), height};
    };
    const auto is_corner = [&](std::uint32_t i) {
      return static_cast<std::uint8_t>(kind < 2 ? i == 0 || i == edges : kind == 2 && i == 0);
    };
    for (std::uint32_t i = 0; i < edges; ++i) {
      const std::uint32_t next = kind >= 2 ? (i + 1) % edges : i + 1;
      features_.push_back({{first + i, first + next},
                           {point(i), point(next)},
                           static_cast<std::int32_t>(chain % 3),
                           {is_corner(i), is_corner(next)},
                           static_cast<std::uint8_t>(chain % 5 == 0)});
    }
    num_vertices_ += kind >= 2 ? edges : edges + 1;
  }

  void number_vertices() {
    std::vector<std::uint32_t> numbers(num_vertices_);
    for (std::uint32_t v = 0; v < num_vertices_; ++v) numbers[v] = v;
    std::ranges::shuffle(numbers, random_);
    for (FoundFeature& f : features_) {
      for (std::uint32_t& v : f.vertices) v = numbers[v];
      if (f.vertices[0] < f.vertices[1]) continue;
      std::swap(f.vertices[0], f.vertices[1]);
      std::swap(f.ends[0], f.ends[1]);
      std::swap(f.corners[0], f.corners[1]);
    }
    std::ranges::sort(features_, {}, &FoundFeature::vertices);
  }

  std::mt19937 random_;
  std::vector<FoundFeature> features_;
  std::uint32_t num_vertices_ = 0;
};

template <class T>
bool same_bytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Each feature of some rank: by its number where `scattered`, else in runs along the list.
std::vector<OwnFeature> share_of(const std::vector<FoundFeature>& all, const Peers& peers, bool scattered) {
  const auto ranks = static_cast<std::size_t>(peers.ranks());
  std::vector<OwnFeature> mine;
  for (std::size_t f = 0; f < all.size(); ++f) {
    const std::size_t rank = scattered ? (f * 2654435761u >> 7) % ranks : f * ranks / all.size();
    if (rank == static_cast<std::size_t>(peers.rank())) mine.push_back({all[f], f % 97 == 0});
  }
  return mine;
}

std::vector<std::uint64_t> keys_of(const meshing::PieceOrder& order, const std::vector<OwnFeature>& mine) {
  std::vector<std::uint64_t> keys;
  for (const OwnFeature& f : mine) keys.push_back(order.key(f.found.ends));
  return keys;
}

/// What one process says.
struct Whole {
  explicit Whole(const std::vector<FoundFeature>& features) : formed(meshing::form_curves(features)) {
    meshing::Box box;
    for (const FoundFeature& f : features)
      for (const Point& p : f.ends) box.include(p);
    order = meshing::PieceOrder(box);
    beside.assign(formed.curves.size(), 0);
    for (std::size_t f = 0; f < features.size(); f += 97) beside[formed.of_features[f].curve.value] = 1;
    for (std::size_t c = 0; c < beside.size(); ++c) in_pieces.push_back(c % 2 == 0);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    for (std::uint32_t f = 0; f < features.size(); ++f)
      if (in_pieces[formed.of_features[f].curve.value]) keys.emplace_back(order.key(features[f].ends), f);
    std::ranges::sort(keys);
    names.assign(features.size(), meshing::kNoName);
    for (std::size_t i = 0; i < keys.size(); ++i)
      names[keys[i].second] = meshing::name_in_order(i, kFirstPiece);
    end = kFirstPiece + meshing::pieces_of(keys.size());
  }

  static constexpr std::uint32_t kFirstPiece = 5;
  meshing::FormedCurves formed;
  meshing::PieceOrder order{meshing::Box{}};
  std::vector<std::uint8_t> beside, in_pieces;
  std::vector<std::uint32_t> names;
  std::uint32_t end = 0;  // of the pieces
};

void expect_whole_curves(const Chains& chains, int ranks, bool scattered) {
  const std::vector<FoundFeature>& all = chains.features();
  const Whole whole(all);
  std::mutex mutex;
  support::run_ranks(ranks, [&](Peers& peers) {
    const std::vector<OwnFeature> mine = share_of(all, peers, scattered);
    FeatureCurves curves(peers, mine);
    const auto first_edges = curves.first_edges();
    curves.name(whole.order, first_keys(peers, keys_of(whole.order, mine)), whole.in_pieces,
                Whole::kFirstPiece);
    std::vector<std::uint32_t> vertices;  // of this rank's, and some more
    for (const OwnFeature& f : mine)
      vertices.insert(vertices.end(), f.found.vertices.begin(), f.found.vertices.end());
    for (std::uint32_t v = 0; v < chains.num_vertices(); v += 3) vertices.push_back(v);
    meshing::sort_unique(vertices);
    const std::vector<FeatureRecord> known = curves.between(asked_at_home(peers, vertices), vertices);

    const std::scoped_lock lock(mutex);
    ASSERT_EQ(curves.found().size(), whole.formed.curves.size());
    for (std::size_t c = 0; c < curves.found().size(); ++c)
      EXPECT_TRUE(same_bytes(curves.found()[c], whole.formed.curves[c])) << "curve " << c;
    EXPECT_EQ(curves.beside_pieces(), whole.beside);
    for (const auto& [first, curve] : first_edges) {
      EXPECT_EQ(first, whole.formed.curves[curve.value].first);
      EXPECT_TRUE(std::ranges::any_of(mine, [&](const OwnFeature& f) { return f.found.vertices == first; }));
    }
    std::size_t at = 0;
    for (std::size_t f = 0; f < all.size(); ++f) {
      const auto has = [&](std::uint32_t v) { return std::ranges::binary_search(vertices, v); };
      if (!has(all[f].vertices[0]) || !has(all[f].vertices[1])) continue;
      ASSERT_LT(at, known.size());
      EXPECT_EQ(known[at].vertices, all[f].vertices);
      EXPECT_EQ(known[at].name, whole.names[f]);
      EXPECT_TRUE(same_bytes(known[at].on, whole.formed.of_features[f]));
      ++at;
    }
    EXPECT_EQ(at, known.size());
    EXPECT_EQ(curves.dealt().end(), whole.end);
  });
}

TEST(FeatureCurves, AreThoseOfAllFeaturesTogether) {
  for (unsigned seed = 0; seed < support::repetitions(4, 40); ++seed) {
    const Chains chains(seed, 3 + 9 * seed, seed % 2 ? 400 : 20);
    for (const int ranks : support::kNumbersOfRanks)
      for (const bool scattered : {false, true}) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", ranks " << ranks << scattered);
        expect_whole_curves(chains, ranks, scattered);
      }
  }
}

TEST(FeatureCurves, MayBeNone) {
  support::run_ranks(4, [](Peers& peers) {
    FeatureCurves curves(peers, {});
    EXPECT_TRUE(curves.found().empty());
    EXPECT_TRUE(curves.first_edges().empty());
    curves.name(meshing::PieceOrder(meshing::Box{}), {}, {}, 3);
    EXPECT_EQ(curves.dealt().end(), 3u);
    EXPECT_TRUE(curves.between(asked_at_home(peers, {}), {}).empty());
  });
}

TEST(DealtPieces, AreOfOneRankEachInTheOrderOfNames) {
  constexpr std::uint32_t kFirst = 7;
  for (const std::uint32_t things : {0u, 1u, 128u, 129u, 1000u})
    for (const int ranks : support::kNumbersOfRanks) {
      SCOPED_TRACE(::testing::Message() << things << " things, ranks " << ranks);
      const DealtPieces dealt(things, kFirst, ranks);
      std::vector<std::uint32_t> names{meshing::kNoName}, expected, joined;
      for (std::uint32_t i = 0; i < things; ++i) expected.push_back(dealt.name(i));
      names.insert(names.end(), expected.rbegin(), expected.rend());
      std::uint32_t next = kFirst;
      for (int rank = 0; rank < ranks; ++rank) {
        const meshing::MadePieces made = dealt.made(rank, names);
        EXPECT_EQ(made.first, next);
        next += meshing::pieces_of(made.members.size());
        for (const std::uint32_t i : made.members) {
          EXPECT_EQ(dealt.maker(names[i]), static_cast<std::size_t>(rank));
          joined.push_back(names[i]);
        }
      }
      EXPECT_EQ(next, dealt.end());
      EXPECT_EQ(joined, expected);
    }
}

/// No rank forms more than its share and one curve.
TEST(FeatureCurves, AreSharedAmongRanks) {
  const Chains chains(7, 200, 60);
  const std::vector<FoundFeature>& all = chains.features();
  for (const int ranks : support::kNumbersOfRanks) {
    std::mutex mutex;
    std::map<std::size_t, std::size_t> formed;  // by rank
    support::run_ranks(ranks, [&](Peers& peers) {
      std::vector<FoundFeature> mine;
      for (const OwnFeature& f : share_of(all, peers, true)) mine.push_back(f.found);
      const std::vector<std::size_t> homes = homes_of_curves(peers, mine);
      const std::scoped_lock lock(mutex);
      for (const std::size_t home : homes) ++formed[home];
    });
    EXPECT_EQ(formed.size(), static_cast<std::size_t>(ranks));
    for (const auto& [rank, count] : formed)
      EXPECT_LE(count, all.size() / static_cast<std::size_t>(ranks) + 60);
  }
}

}  // namespace
}  // namespace weft::partition::feature_curves_test

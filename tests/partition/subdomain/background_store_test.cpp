// Joined pieces answer as the whole background does, wherever they cover it, in whatever order they came.
#include "partition/subdomain/background_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/partition/scenes.h"

namespace weft::partition::background_store_test {
namespace {

using namespace weft::support;
using Pieces = std::vector<std::shared_ptr<const BackgroundPiece>>;
using meshing::Background;
using meshing::LogMetric;
using meshing::Point;

/// A body of some thousand tets, so that there are pieces to join, with its metric as one background.
class Whole {
 public:
  explicit Whole(unsigned seed) : mesh(seed % 2 ? two_bodies(6) : layered_box(7, 4, 3)) {
    jitter_interior(mesh, 0.01, seed);
    if (seed % 3) shuffle(mesh, seed);
    log_metrics = wanted_sizes(mesh, 0.2, seed);
    background = std::make_unique<Background>(mesh, log_metrics,
                                              meshing::build_adjacency(mesh.tets, mesh.points.size()));
  }

  /// The store of subdomain s, which has the tets of part s; vertices are named by their numbers.
  BackgroundStore store(SubdomainId s, const std::vector<SubdomainId>& part) const {
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (std::size_t t = 0; t < part.size(); ++t)
      if (part[t] == s) tets.push_back(mesh.tets[t]);
    std::vector<GlobalId> ids;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) ids.emplace_back(SubdomainId(0), v);
    return {s, mesh.points, log_metrics, ids, tets, meshing::build_adjacency(tets, mesh.points.size())};
  }

  meshing::MeshData mesh;
  meshing::LogMetricField log_metrics;
  std::unique_ptr<Background> background;
};

Point random_point_in(const std::array<std::uint32_t, 4>& tet, const std::vector<Point>& points,
                      std::mt19937& random) {
  std::exponential_distribution<double> weight(1);
  std::array<double, 4> w;
  double sum = 0;
  for (double& x : w) sum += x = weight(random);
  Point p;
  for (int i = 0; i < 4; ++i) p += (w[i] / sum) * points[tet[i]];
  return p;
}

void expect_same(const LogMetric& a, const LogMetric& b) {
  for (const auto member :
       {&LogMetric::xx, &LogMetric::xy, &LogMetric::yy, &LogMetric::xz, &LogMetric::yz, &LogMetric::zz})
    EXPECT_NEAR(a.*member, b.*member, 1e-9);
}

/// At random points of the tets that the store has, from any hint.
void expect_answers(const BackgroundStore& store, const Whole& whole, unsigned seed) {
  std::mt19937 random(seed);
  const meshing::MeshData& mesh = store.background().mesh();
  for (int i = 0; i < 300; ++i) {
    const auto tet = static_cast<std::uint32_t>(random() % mesh.tets.size());
    const Point p = random_point_in(mesh.tets[tet], mesh.points, random);
    const LogMetric expected = whole.background->at(p, Background::kNoHint).log_metric;
    expect_same(store.background().at(p, tet).log_metric, expected);
    const auto place = store.background().locate(p, static_cast<std::uint32_t>(random() % mesh.tets.size()));
    EXPECT_EQ(place.distance2, 0);
    LogMetric there;
    for (int k = 0; k < 4; ++k)
      there = there + place.at[k] * store.background().log_metric(mesh.tets[place.tet][k]);
    expect_same(there, expected);
  }
}

std::vector<SubdomainId> parts(const meshing::MeshData& mesh, std::uint32_t count, unsigned way,
                               unsigned seed) {
  Scene scene;
  scene.mesh = mesh;
  cut_at_random(scene, count, way, seed);
  return scene.part;
}

TEST(BackgroundStore, AnswersWhereItCovers) {
  for (unsigned seed = 0; seed < 9; ++seed) {
    SCOPED_TRACE(seed);
    const Whole whole(seed);
    const auto part = parts(whole.mesh, 4, seed % 3, seed);
    std::size_t tets = 0;
    for (SubdomainId s(0); s.value < 4; ++s.value) {
      const BackgroundStore store = whole.store(s, part);
      tets += store.background().mesh().tets.size();
      expect_answers(store, whole, seed);
    }
    EXPECT_EQ(tets, whole.mesh.tets.size());
  }
}

/// As many joined faces as the tets that are here have in common.
std::size_t count_joined(const BackgroundStore& store) {
  std::size_t joined = 0;
  const auto& neighbours = store.background().adjacency().neighbours;
  for (std::uint32_t t = 0; t < neighbours.size(); ++t)
    for (std::uint32_t f = 0; f < 4; ++f) {
      const std::uint32_t other = neighbours[t][f];
      if (other == meshing::kNoNeighbour) continue;
      ++joined;
      EXPECT_EQ(neighbours[other >> 2][other & 3], 4 * t + f);
    }
  return joined;
}

TEST(BackgroundStore, PiecesJoinInAnyOrderAndOnlyOnce) {
  for (unsigned seed = 0; seed < 9; ++seed) {
    SCOPED_TRACE(seed);
    const Whole whole(seed);
    const auto part = parts(whole.mesh, 5, seed % 3, seed);
    Pieces all;
    for (SubdomainId s(0); s.value < 5; ++s.value) {
      const BackgroundStore store = whole.store(s, part);
      for (auto piece : store.all_pieces()) all.push_back(std::move(piece));
    }
    std::mt19937 random(seed);
    std::shuffle(all.begin(), all.end(), random);
    BackgroundStore joined;
    for (std::size_t i = 0; i < all.size();) {
      const std::size_t end = std::min(all.size(), i + 1 + random() % 4);
      Pieces some(all.begin() + static_cast<std::ptrdiff_t>(i),
                  all.begin() + static_cast<std::ptrdiff_t>(end));
      some.push_back(all[random() % end]);  // is here already, or comes twice
      joined.add(some);
      i = end;
    }
    EXPECT_EQ(joined.all_pieces().size(), all.size());
    EXPECT_EQ(joined.background().mesh().tets.size(), whole.mesh.tets.size());
    std::size_t common = 0;
    for (const auto& n : whole.background->adjacency().neighbours)
      common += 4 - static_cast<std::size_t>(std::count(n.begin(), n.end(), meshing::kNoNeighbour));
    EXPECT_EQ(count_joined(joined), common);
    expect_answers(joined, whole, seed);
  }
}

TEST(BackgroundStore, NamesAndNumbersRoundTripAndStay) {
  const Whole whole(2);
  const auto part = parts(whole.mesh, 3, 0, 2);
  BackgroundStore store = whole.store(SubdomainId(1), part);
  const auto own = static_cast<std::uint32_t>(store.background().mesh().tets.size());
  std::vector<BackgroundTet> names;
  for (std::uint32_t t = 0; t < own; ++t) {
    names.push_back(store.name_of(t));
    EXPECT_TRUE(store.has(names[t].piece));
    EXPECT_EQ(store.tet_of(names[t]), t);
  }
  for (const SubdomainId other : {SubdomainId(0), SubdomainId(2)}) {
    const BackgroundStore there = whole.store(other, part);
    store.add(there.pieces(there.piece_ids()));
  }
  for (std::uint32_t t = 0; t < own; ++t) EXPECT_EQ(store.tet_of(names[t]), t);
  const BackgroundStore fresh = whole.store(SubdomainId(2), part);
  for (std::uint32_t t = 0; t < fresh.background().mesh().tets.size(); ++t) {
    // Another subdomain finds the same tet by its name: the same corners.
    const std::uint32_t here = store.tet_of(fresh.name_of(t));
    for (int i = 0; i < 4; ++i) {
      const Point a = fresh.background().mesh().points[fresh.background().mesh().tets[t][i]];
      const Point b = store.background().mesh().points[store.background().mesh().tets[here][i]];
      EXPECT_EQ(norm(a - b), 0);
    }
  }
}

TEST(BackgroundStore, GivesPiecesByTheirIds) {
  const Whole whole(0);
  const BackgroundStore store =
      whole.store(SubdomainId(0), std::vector<SubdomainId>(whole.mesh.tets.size(), SubdomainId(0)));
  ASSERT_GT(store.all_pieces().size(), 3u);
  const std::vector<std::uint64_t> ids{store.all_pieces()[0]->id, store.all_pieces()[2]->id};
  const Pieces found = store.pieces(ids);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0], store.all_pieces()[0]);
  EXPECT_EQ(found[1], store.all_pieces()[2]);
  EXPECT_TRUE(store.pieces({}).empty());
}

TEST(BackgroundStore, StaysValidWhenMoved) {
  const Whole whole(1);
  BackgroundStore store = whole.store(SubdomainId(0), parts(whole.mesh, 2, 0, 1));
  const BackgroundStore moved = std::move(store);
  expect_answers(moved, whole, 1);
}

TEST(BackgroundStore, PiecesOfTwoSubdomainsHaveDifferentIds) {
  const Whole whole(0);
  const auto part = parts(whole.mesh, 3, 1, 0);
  std::set<std::uint64_t> ids;
  std::size_t pieces = 0;
  for (SubdomainId s(0); s.value < 3; ++s.value) {
    const BackgroundStore store = whole.store(s, part);
    for (const auto& piece : store.all_pieces()) ids.insert(piece->id);
    pieces += store.all_pieces().size();
  }
  EXPECT_EQ(ids.size(), pieces);
}

}  // namespace
}  // namespace weft::partition::background_store_test

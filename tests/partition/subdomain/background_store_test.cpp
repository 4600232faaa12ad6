// Joined pieces answer as the whole background does, wherever they cover it, in whatever order they came.
#include "partition/subdomain/background_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>
#include <stdexcept>

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

Point random_point_in(const std::array<Point, 4>& tet, std::mt19937& random) {
  std::exponential_distribution<double> weight(1);
  std::array<double, 4> w;
  double sum = 0;
  for (double& x : w) sum += x = weight(random);
  Point p;
  for (int i = 0; i < 4; ++i) p += (w[i] / sum) * tet[i];
  return p;
}

void expect_same(const LogMetric& a, const LogMetric& b) {
  for (const auto member :
       {&LogMetric::xx, &LogMetric::xy, &LogMetric::yy, &LogMetric::xz, &LogMetric::yz, &LogMetric::zz})
    EXPECT_NEAR(a.*member, b.*member, 1e-9);
}

struct NumberedTet {
  std::uint32_t number;
  std::array<Point, 4> corners;
};

/// All of them, in the order of their numbers.
std::vector<NumberedTet> tets_of(const BackgroundStore& store) {
  std::vector<NumberedTet> tets;
  for (const auto& piece : store.all_pieces())
    for (std::uint32_t t = 0; t < piece->tets.size(); ++t) {
      tets.push_back({store.tet_of({piece->id, t}), {}});
      for (std::size_t i = 0; i < 4; ++i) tets.back().corners[i] = piece->points[piece->tets[t][i]];
    }
  return tets;
}

/// At random points of the tets that the store has, from these.
void expect_answers(const BackgroundStore& store, const Whole& whole, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<NumberedTet> tets = tets_of(store);
  for (int i = 0; i < 300; ++i) {
    const NumberedTet& tet = tets[random() % tets.size()];
    const Point p = random_point_in(tet.corners, random);
    const LogMetric expected = whole.background->at(p, Background::kNoHint).log_metric;
    expect_same(store.background().at(p, tet.number).log_metric, expected);
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
      tets += tets_of(store).size();
      expect_answers(store, whole, seed);
    }
    EXPECT_EQ(tets, whole.mesh.tets.size());
  }
}

/// As many joined faces as the tets that are here have in common.
std::size_t count_joined(const BackgroundStore& store) {
  std::size_t joined = 0;
  const Background& background = store.background();
  for (const NumberedTet& tet : tets_of(store))
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t other = background.neighbour(tet.number, f);
      if (other == meshing::kNoNeighbour) continue;
      ++joined;
      EXPECT_EQ(background.neighbour(other >> 2, static_cast<int>(other & 3)),
                4 * tet.number + static_cast<std::uint32_t>(f));
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
    EXPECT_EQ(tets_of(joined).size(), whole.mesh.tets.size());
    std::size_t common = 0;
    const auto adjacency = meshing::build_adjacency(whole.mesh.tets, whole.mesh.points.size());
    for (const auto& n : adjacency.neighbours)
      common += 4 - static_cast<std::size_t>(std::count(n.begin(), n.end(), meshing::kNoNeighbour));
    EXPECT_EQ(count_joined(joined), common);
    expect_answers(joined, whole, seed);
  }
}

TEST(BackgroundStore, NamesAndNumbersRoundTripAndStay) {
  const Whole whole(2);
  const auto part = parts(whole.mesh, 3, 0, 2);
  BackgroundStore store = whole.store(SubdomainId(1), part);
  const std::vector<NumberedTet> own = tets_of(store);
  std::vector<BackgroundTet> names;
  for (std::uint32_t t = 0; t < own.size(); ++t) {
    EXPECT_EQ(own[t].number, t) << "those of its start keep their numbers";
    names.push_back(store.name_of(t));
    EXPECT_TRUE(store.has(names[t].piece));
    EXPECT_EQ(store.tet_of(names[t]), t);
  }
  for (const SubdomainId other : {SubdomainId(0), SubdomainId(2)}) {
    const BackgroundStore there = whole.store(other, part);
    store.add(there.pieces(there.piece_ids()));
  }
  for (std::uint32_t t = 0; t < own.size(); ++t) EXPECT_EQ(store.tet_of(names[t]), t);
  const BackgroundStore fresh = whole.store(SubdomainId(2), part);
  const std::vector<NumberedTet> here = tets_of(store);
  for (const NumberedTet& tet : tets_of(fresh)) {
    // Another subdomain finds the same tet by its name: the same corners.
    const std::uint32_t number = store.tet_of(fresh.name_of(tet.number));
    const auto same = std::ranges::lower_bound(here, number, {}, &NumberedTet::number);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(norm(tet.corners[i] - same->corners[i]), 0);
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

TEST(BackgroundPiece, IsReadFromTheBytesOfAnotherAndFromNoOthers) {
  const Whole whole(0);
  const BackgroundStore store = whole.store(SubdomainId(0), parts(whole.mesh, 2, 0, 1));
  for (const auto& piece : store.all_pieces()) {
    const BackgroundPiece same(piece->bytes(), piece->owner());
    EXPECT_EQ(same.tets.data(), piece->tets.data());
    EXPECT_EQ(same.neighbours.data(), piece->neighbours.data());
    EXPECT_THROW(BackgroundPiece(piece->bytes().first(piece->bytes().size() - 8), piece->owner()),
                 std::runtime_error);
    EXPECT_THROW(BackgroundPiece(piece->bytes().first(8), piece->owner()), std::runtime_error);
  }
}

/// Subdomains of a rank have a piece in one copy, whichever way it came, and answer as before; what nobody
/// has any more is gone.
TEST(BackgroundStore, PiecesAreOnceOnARank) {
  const Whole whole(1);
  const auto part = parts(whole.mesh, 2, 0, 1);
  SharedPieces<BackgroundPiece> rank;
  BackgroundStore a = whole.store(SubdomainId(0), part);
  {
    BackgroundStore b = whole.store(SubdomainId(1), part);
    Pieces arrived;  // copies, as other ranks send them
    for (const auto& piece : a.all_pieces()) arrived.push_back(std::make_shared<BackgroundPiece>(*piece));
    b.add(arrived);
    a.share(rank);
    b.share(rank);
    for (const auto& piece : a.all_pieces()) {
      EXPECT_EQ(b.pieces({{piece->id}}).front(), piece);
      EXPECT_EQ(piece.use_count(), 2);
    }
    arrived.clear();
    expect_answers(a, whole, 1);
    expect_answers(b, whole, 2);
  }
  for (const auto& piece : a.all_pieces()) EXPECT_EQ(piece.use_count(), 1);
}

TEST(SharedPieces, DoesNotKeepNamesOfWhatIsGone) {
  struct Numbered {
    std::uint32_t id;
  };
  SharedPieces<Numbered> rank;
  for (std::uint32_t id = 0; id < 10000; ++id) {
    std::vector<std::shared_ptr<const Numbered>> pieces{std::make_shared<Numbered>(id)};
    EXPECT_FALSE(rank.share(pieces));
  }
  EXPECT_LT(rank.size(), 100);
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

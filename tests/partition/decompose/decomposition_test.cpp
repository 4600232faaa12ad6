// Every partitioner: the same for any number of ranks, balanced, and whole.
#include "partition/decompose/decomposition.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include "meshing/mesh/structured_box.h"
#include "partition/decompose/dual_graph.h"
#include "partition/decompose/graph_partition.h"
#include "partition/decompose/inertia.h"
#include "partition/decompose/ordered_cuts.h"
#include "partition/decompose/slabs.h"
#include "partition/decompose/tet_measures.h"
#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/support/meshes.h"

namespace weft::partition::decomposition_test {
namespace {

using meshing::MeshData;
using meshing::Metric;
using meshing::Point;
using meshing::SymTensor;

/// All items of a case.
struct Whole {
  std::vector<Point> centres;
  std::vector<TetCorners> corners;
  std::vector<double> work;
  std::vector<SymTensor> cut_tensors;
  std::vector<std::array<std::uint32_t, 4>> vertices;
  std::vector<std::array<float, 4>> face_areas;
  std::vector<double> complexities;
};

/// The work is what the metric asks for.
Whole whole_of(const MeshData& mesh, const std::function<Metric(const Point&)>& metric) {
  Whole w;
  for (const auto& t : mesh.tets) {
    const TetCorners tet{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]};
    w.corners.push_back(tet);
    w.centres.push_back(0.25 * (tet[0] + tet[1] + tet[2] + tet[3]));
    const Metric m = metric(w.centres.back());
    w.work.push_back(six_volume(tet[0], tet[1], tet[2], tet[3]) * std::sqrt(determinant(m)));
    w.complexities.push_back(w.work.back() / 6);
    const SymTensor inverse = unit_inverse(log_of(m));
    w.cut_tensors.push_back(cut_tensor(tet, inverse));
    w.face_areas.push_back(face_areas(tet, inverse, std::cbrt(determinant(m))));
  }
  w.vertices = mesh.tets;
  return w;
}

/// Of equal work, sizes 1.
Whole whole_of(const MeshData& mesh) {
  Whole w = whole_of(mesh, [](const Point&) { return meshing::identity_tensor(); });
  w.work.assign(mesh.tets.size(), 1);
  return w;
}

/// Jittered, shuffled cells, more work near one corner.
Whole random_whole(std::uint32_t cells, unsigned seed) {
  MeshData mesh = support::unit_cube(cells);
  support::jitter_interior(mesh, 0.1 / cells, seed);
  support::shuffle(mesh, seed);
  Whole w = whole_of(mesh);
  for (std::size_t i = 0; i < w.work.size(); ++i) w.work[i] = std::exp(-5 * norm(w.centres[i]));
  return w;
}

/// This rank's items, and their numbers.
std::pair<Whole, std::vector<std::uint64_t>> dealt(const Peers& peers, const Whole& w) {
  Whole mine;
  std::vector<std::uint64_t> numbers;
  for (std::size_t i = 0; i < w.work.size(); ++i) {
    if (static_cast<int>(i / 3 % 17) % peers.ranks() != peers.rank()) continue;
    mine.centres.push_back(w.centres[i]);
    mine.corners.push_back(w.corners[i]);
    mine.work.push_back(w.work[i]);
    mine.cut_tensors.push_back(w.cut_tensors[i]);
    mine.vertices.push_back(w.vertices[i]);
    mine.face_areas.push_back(w.face_areas[i]);
    mine.complexities.push_back(w.complexities[i]);
    numbers.push_back(i);
  }
  return {std::move(mine), std::move(numbers)};
}

/// As the previous one, but nearly all work lies in every hundredth item.
Whole crowded_whole(std::uint32_t cells) {
  Whole w = whole_of(support::unit_cube(cells));
  for (std::size_t i = 0; i < w.work.size(); ++i) w.work[i] = i % 100 == 0 ? 1000 : 0.01;
  return w;
}

/// The subdomain of every item, the items being dealt out to `ranks` ranks.
std::vector<SubdomainId> decompose_on(int ranks, const Whole& w, std::uint32_t n, const std::string& name) {
  std::vector<SubdomainId> all(w.work.size());
  support::run_ranks(ranks, [&](Peers& peers) {
    const auto [mine, numbers] = dealt(peers, w);
    const Decomposition found = decompose(peers,
                                          {mine.centres, mine.corners, mine.work, numbers, mine.cut_tensors,
                                           mine.vertices, mine.face_areas, mine.complexities},
                                          n, parse_partitioner(name, n));
    for (std::size_t k = 0; k < numbers.size(); ++k) all[numbers[k]] = found.subdomains[k];
  });
  return all;
}

std::vector<double> loads(const Whole& w, const std::vector<SubdomainId>& subdomains, std::uint32_t n) {
  std::vector<double> result(n, 0);
  for (std::size_t i = 0; i < w.work.size(); ++i) result[subdomains[i].value] += w.work[i];
  return result;
}

class Partitioners : public ::testing::TestWithParam<std::string> {};

TEST(GraphPartition, HeavyItemsAreSpreadWithoutAWordOfTheLibrary) {
  const Whole w = crowded_whole(8);  // 31 heavy ones
  for (const std::uint32_t n : {6u, 24u, 64u}) {
    testing::internal::CaptureStdout();
    const std::vector<SubdomainId> parts = decompose_on(1, w, n, "graph");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "") << n;
    std::vector<int> heavy(n, 0);
    for (std::size_t i = 0; i < parts.size(); i += 100) ++heavy[parts[i].value];
    EXPECT_LE(std::ranges::max(heavy), n == 6 ? 7 : n == 24 ? 3 : 2) << n;
    EXPECT_EQ(decompose_on(3, w, n, "graph"), parts) << n;
  }
}

TEST_P(Partitioners, DoNotDependOnTheNumberOfRanks) {
  const Whole w = random_whole(5, 3);
  for (const std::uint32_t n : {1u, 2u, 3u, 16u, 128u, 1000u}) {
    const auto expected = decompose_on(1, w, n, GetParam());
    for (const SubdomainId s : expected) ASSERT_LT(s.value, n);
    for (const int ranks : support::kNumbersOfRanks)
      ASSERT_EQ(decompose_on(ranks, w, n, GetParam()), expected) << n << " subdomains, " << ranks << " ranks";
  }
}

TEST_P(Partitioners, BalanceWork) {
  const Whole w = random_whole(8, 4);
  const double total = std::accumulate(w.work.begin(), w.work.end(), 0.0);
  const double heaviest = *std::max_element(w.work.begin(), w.work.end());
  for (const std::uint32_t n : {2u, 3u, 16u, 24u}) {
    const double levels = GetParam() == "bisection" ? std::ceil(std::log2(n)) : 3;
    // METIS: 3 % of a part and a tet.
    const double slack = GetParam() == "graph" ? 0.03 * total / n + heaviest : levels * heaviest;
    for (const double load : loads(w, decompose_on(2, w, n, GetParam()), n)) {
      EXPECT_LE(load, total / n + slack) << n;
      EXPECT_GE(load, GetParam() == "graph" ? 0.8 * total / n : total / n - slack) << n;
    }
  }
}

TEST_P(Partitioners, AcceptAnyWork) {
  Whole w = random_whole(3, 5);
  for (const double scale : {0.0, 1e-320, 1e300}) {
    for (std::size_t i = 0; i < w.work.size(); ++i) w.work[i] = i % 7 == 0 ? scale : 1e-3 * scale;
    for (const SubdomainId s : decompose_on(3, w, 5, GetParam())) EXPECT_LT(s.value, 5u);
  }
  w.work.assign(w.work.size(), 0);  // without work, tets are counted
  std::vector<std::uint32_t> counts(4, 0);
  for (const SubdomainId s : decompose_on(3, w, 4, GetParam())) ++counts[s.value];
  for (const std::uint32_t count : counts) EXPECT_NEAR(count, w.work.size() / 4.0, 4);
}

TEST_P(Partitioners, LeaveSubdomainsEmptyWhereTetsAreFew) {
  const Whole w = whole_of(support::two_tets());
  for (const int ranks : support::kNumbersOfRanks) {
    const auto subdomains = decompose_on(ranks, w, 100, GetParam());
    EXPECT_NE(subdomains[0], subdomains[1]);
    for (const SubdomainId s : subdomains) EXPECT_LT(s.value, 100u);
  }
}

TEST_P(Partitioners, CutTetsThatAllLieInOnePlace) {
  Whole w = random_whole(3, 6);
  const Point place{0.25, -1, 3};
  std::fill(w.centres.begin(), w.centres.end(), place);
  std::fill(w.corners.begin(), w.corners.end(), TetCorners{place, place, place, place});
  std::fill(w.work.begin(), w.work.end(), 2.0);
  std::vector<std::uint32_t> counts(6, 0);
  for (const SubdomainId s : decompose_on(4, w, 6, GetParam())) ++counts[s.value];
  for (const std::uint32_t count : counts) EXPECT_NEAR(count, w.work.size() / 6.0, 3);
}

TEST_P(Partitioners, RefuseNoSubdomains) {
  SelfPeers alone;
  EXPECT_THROW(decompose(alone, {}, 0, parse_partitioner(GetParam())), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Decomposition, Partitioners,
                         ::testing::Values("pqr", "pqr:principal", "bisection", "graph"),
                         [](const auto& test) {
                           return test.param == "pqr:principal" ? "principal" : test.param;
                         });

TEST(Pqr, SlabsAreSortedAlongTheirAxes) {
  const Whole w = random_whole(6, 8);
  const auto subdomains = decompose_on(3, w, 24, "pqr:4x3x2");
  // Bounds of each slab in x, of each column in y within its slab, of each part in z within its column.
  const auto expect_sorted = [&](int axis, std::uint32_t parts_below, std::uint32_t siblings) {
    std::map<std::uint32_t, std::pair<double, double>> bounds;
    for (std::size_t i = 0; i < subdomains.size(); ++i) {
      double x = w.corners[i][0][axis];
      for (const Point& p : w.corners[i]) x = std::max(x, p[axis]);
      auto& [lo, hi] = bounds.try_emplace(subdomains[i].value / parts_below, x, x).first->second;
      lo = std::min(lo, x), hi = std::max(hi, x);
    }
    for (const auto& [slab, bound] : bounds)
      EXPECT_TRUE(slab % siblings == 0 || bound.first >= bounds.at(slab - 1).second);
  };
  expect_sorted(0, 6, 4);
  expect_sorted(1, 2, 3);
  expect_sorted(2, 1, 2);
}

TEST(Pqr, ThinSlabsStayUnlessFewerAreAskedFor) {
  Whole w = whole_of(support::unit_cube(6), [](const Point&) { return 400.0 * meshing::identity_tensor(); });
  const auto number_of = [&](const std::string& name) {
    const auto found = decompose_on(2, w, 30, name);
    return std::set<SubdomainId>(found.begin(), found.end()).size();
  };
  EXPECT_EQ(number_of("pqr:30x1x1:fewer"), 8u);
  EXPECT_EQ(number_of("pqr:30x1x1"), 30u);
  w.complexities.assign(w.work.size(), 1e9);
  EXPECT_EQ(number_of("pqr:30x1x1:fewer"), 30u);
}

TEST(Pqr, RefusesSlabsOfAnotherProduct) {
  SelfPeers alone;
  EXPECT_THROW(decompose(alone, {}, 5, parse_partitioner("pqr:2x2x2")), std::invalid_argument);
}

TEST(Pqr, SlabsSuitTheBox) {
  using ::testing::ElementsAre;
  EXPECT_THAT(suitable_slabs(8, {1, 1, 1}), ElementsAre(2, 2, 2));
  EXPECT_THAT(suitable_slabs(12, {1, 3, 2}), ElementsAre(1, 4, 3));
  EXPECT_THAT(suitable_slabs(16, {100, 1, 1}), ElementsAre(16, 1, 1));
  EXPECT_THAT(suitable_slabs(7, {1, 1, 9}), ElementsAre(1, 1, 7));
}

TEST(Bisection, CutsAcrossTheLongestPrincipalAxis) {
  // A bar along (1, 1, 0): the first cut separates its halves.
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  Whole w;
  for (int i = 0; i < 1000; ++i) {
    const double s = 10 * unit(random);
    const Point p{s + unit(random), s + unit(random), unit(random)};
    w.centres.push_back(p);
    w.corners.push_back({p, p, p, p});
  }
  w.work.assign(1000, 1);
  w.cut_tensors.assign(1000, meshing::identity_tensor());
  w.vertices.resize(1000);
  w.face_areas.resize(1000);
  w.complexities.resize(1000);
  const auto subdomains = decompose_on(2, w, 2, "bisection");
  double least = 100, greatest = -100;
  for (std::size_t i = 0; i < 1000; ++i) {
    const double along = w.centres[i].x + w.centres[i].y;
    if (subdomains[i].value == 0)
      greatest = std::max(greatest, along);
    else
      least = std::min(least, along);
  }
  EXPECT_LT(greatest - least, 1.5);  // the axis is found to a few percent
}

// All ranks cut together while a group is more than a rank's share: some ten exchanges a level.
TEST(Bisection, SmallGroupsAreCutByOneRankEach) {
  const Whole w = random_whole(10, 4);
  constexpr std::uint32_t n = 256;
  const auto expected = decompose_on(1, w, n, "bisection");
  std::vector<SubdomainId> all(w.work.size());
  std::vector<std::size_t> exchanges(8);
  support::run_ranks(8, [&](Peers& plain) {
    support::CountingPeers peers(plain);
    const auto [mine, numbers] = dealt(peers, w);
    const std::vector<std::uint64_t> weights = integer_weights(peers, mine.work);
    const auto found = bisection(peers, {mine.centres, mine.corners, weights, numbers, mine.cut_tensors}, n);
    for (std::size_t k = 0; k < numbers.size(); ++k) all[numbers[k]] = found[k];
    exchanges[static_cast<std::size_t>(peers.rank())] = peers.exchanges;
  });
  EXPECT_EQ(all, expected);
  for (const std::size_t e : exchanges) EXPECT_LT(e, 70u);
}

TEST(PrincipalAxes, AreThoseOfAnEllipsoid) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Axes expected{Point{0.6, 0.8, 0}, Point{0, 0, 1}, Point{0.8, -0.6, 0}};
  std::vector<Point> points;
  for (int i = 0; i < 20000; ++i)
    points.push_back(Point{1000, 0, 0} + 9 * normal(random) * expected[0] + 3 * normal(random) * expected[1] +
                     normal(random) * expected[2]);
  SelfPeers alone;
  const std::vector<std::uint64_t> weights(points.size(), std::uint64_t{1} << 40), numbers(points.size());
  const std::vector<std::uint32_t> groups(points.size(), 0);
  const Axes found = principal_axes(covariances(alone, {points, {}, weights, numbers, {}}, groups, 1)[0]);
  for (int i = 0; i < 3; ++i) EXPECT_GT(dot(found[i], expected[i]), 0.999) << i;
}

TEST(CuttingAxis, IsACoordinateAxisWhereThatIsNearlyAsWide) {
  const Point y{0, 1, 0};
  const SymTensor round = meshing::identity_tensor();
  EXPECT_EQ(cutting_axis({1, 0.01, 1.001, 0.02, 0.03, 1}, round), y);  // a cube, with some rounding
  EXPECT_EQ(cutting_axis({1, 0, 5, 0, 0.1, 1}, round), y);
  const Point oblique = cutting_axis({3, 2.9, 3, 0, 0, 1}, round);  // along (1, 1, 0)
  EXPECT_NEAR(std::abs(oblique.x), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(oblique.x, oblique.y, 1e-9);
  EXPECT_EQ(norm(cutting_axis({}, {})), 1);  // a single place
}

TEST(CuttingAxis, IsLongestInWantedSizes) {
  const SymTensor cube = meshing::identity_tensor();
  EXPECT_EQ(cutting_axis(cube, {1, 0, 1, 0, 0, 0.01}), (Point{0, 0, 1}));
  EXPECT_EQ(cutting_axis({100, 0, 1, 0, 0, 1}, {1, 0, 1, 0, 0, 0.001}), (Point{0, 0, 1}));
  EXPECT_EQ(cutting_axis({100, 0, 1, 0, 0, 1}, {1, 0, 1, 0, 0, 0.1}), (Point{1, 0, 0}));
  EXPECT_EQ(cutting_axis(cube, {1, 0, 0, 0, 0, 0}), (Point{0, 1, 0}));  // infinitely thin in a plane
  // Sizes of 0.1 along (1, 1, 0), of 1 across it.
  const Point oblique = cutting_axis(cube, {0.505, -0.495, 0.505, 0, 0, 1});
  EXPECT_NEAR(std::abs(oblique.x), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(oblique.x, oblique.y, 1e-9);
}

/// Area, in the metric, of the faces between different subdomains.
double interface_area(const Whole& w, const std::vector<SubdomainId>& subdomains) {
  std::map<std::array<std::uint32_t, 3>, SubdomainId> open;
  double area = 0;
  for (std::size_t t = 0; t < w.vertices.size(); ++t)
    for (std::size_t skipped = 0; skipped < 4; ++skipped) {
      std::array<std::uint32_t, 3> face;
      for (std::size_t i = 0; i < 3; ++i) face[i] = w.vertices[t][i < skipped ? i : i + 1];
      std::sort(face.begin(), face.end());
      const auto [it, fresh] = open.try_emplace(face, subdomains[t]);
      if (!fresh && it->second != subdomains[t]) area += w.face_areas[t][skipped];
    }
  return area;
}

// 8 cubes have 3 unit squares between them; cut along the cells' diagonals they have at most twice as much.
TEST(Interfaces, AreSmall) {
  MeshData mesh = support::unit_cube(12);
  support::shuffle(mesh, 3);
  const Whole w = whole_of(mesh);
  for (const char* name : {"pqr", "bisection", "graph"})
    EXPECT_LT(interface_area(w, decompose_on(3, w, 8, name)), 2 * 3.0) << name;
}

/// Items whose partitioners are told that all sizes are equal.
Whole blind_to_sizes(Whole w) {
  for (auto& areas : w.face_areas) areas.fill(1);
  for (auto& tensor : w.cut_tensors) tensor = meshing::identity_tensor();
  return w;
}

MeshData jittered_cube() {
  MeshData mesh = support::unit_cube(16);
  support::jitter_interior(mesh, 0.015, 4);
  support::shuffle(mesh, 4);
  return mesh;
}

// A box of 0.6 x 1 x 1 that is 60 x 10 x 10 in wanted sizes, as its cells are.
TEST(Interfaces, AvoidWhatTheMetricMakesLarge) {
  MeshData mesh = meshing::structured_box({{48, 8, 8}, {0, 0, 0}, {0.6, 1, 1}});
  support::shuffle(mesh, 5);
  const Whole w = whole_of(mesh, [](const Point&) { return SymTensor{1e4, 0, 100, 0, 0, 100}; });
  const Whole blind = blind_to_sizes(w);
  for (const auto& [name, share] : {std::pair("bisection", 0.7), std::pair("graph", 0.95)}) {
    const double area = interface_area(w, decompose_on(2, w, 8, name));
    EXPECT_LT(area, share * interface_area(w, decompose_on(2, blind, 8, name))) << name;
    EXPECT_LT(area, 1.2 * 7 * 100) << name;
  }
}

// Sizes of 0.001 to 0.1 across a layer round the z axis, up to 0.1 along it: along the layer faces do better
// than any plane.
TEST(Interfaces, FollowFacesAlongALayer) {
  const Whole w = whole_of(jittered_cube(), meshing::AnalyticMetric("polar-2"));
  const Whole blind = blind_to_sizes(w);
  for (const std::uint32_t n : {8u, 16u, 32u}) {
    EXPECT_LT(interface_area(w, decompose_on(2, w, n, "graph")),
              0.75 * interface_area(w, decompose_on(2, blind, n, "graph")));
    EXPECT_LT(interface_area(w, decompose_on(2, w, n, "bisection")),
              1.05 * interface_area(w, decompose_on(2, blind, n, "bisection")));
  }
}

/// By graph, in groups where there are more than `most` items, which are gone once they are read.
/// `most_bytes`: that a rank has got at once.
std::vector<SubdomainId> graph_parts(int ranks, const Whole& w, std::uint32_t n, std::uint64_t most,
                                     std::size_t* most_bytes = nullptr) {
  std::vector<SubdomainId> all(w.work.size());
  std::vector<std::size_t> bytes(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& plain) {
    support::CountingPeers peers(plain);
    auto [mine, numbers] = dealt(peers, w);
    const std::vector<std::uint64_t> weights = integer_weights(peers, mine.work);
    int calls = 0;
    const auto items_are_read = [&calls, &mine = mine] {
      ++calls;
      mine = {};
    };
    const auto found =
        graph_partition(peers, {mine.centres, mine.corners, weights, numbers, mine.cut_tensors},
                        {mine.vertices, mine.face_areas}, n, most, items_are_read);
    EXPECT_EQ(calls, 1);
    for (std::size_t k = 0; k < numbers.size(); ++k) all[numbers[k]] = found[k];
    bytes[static_cast<std::size_t>(peers.rank())] = peers.most;
  });
  if (most_bytes) *most_bytes = std::ranges::max(bytes);
  return all;
}

TEST(GraphPartition, BisectsWhatIsTooLargeForAGraph) {
  const Whole w = random_whole(8, 9);
  const double total = std::accumulate(w.work.begin(), w.work.end(), 0.0);
  constexpr std::uint32_t n = 12;
  const double area = interface_area(w, graph_parts(1, w, n, w.work.size()));
  for (const std::uint64_t most : {1500, 400}) {
    const auto expected = graph_parts(1, w, n, most);
    for (const double load : loads(w, expected, n)) EXPECT_NEAR(load, total / n, 0.15 * total / n) << most;
    EXPECT_LT(interface_area(w, expected), 2 * area) << most;
    EXPECT_NE(expected, graph_parts(1, w, n, w.work.size()));
    for (const int ranks : support::kNumbersOfRanks)
      EXPECT_EQ(graph_parts(ranks, w, n, most), expected) << ranks;
  }
  EXPECT_EQ(graph_parts(2, w, n, 1), decompose_on(2, w, n, "bisection"));
}

/// 24,576 tets of equal work in subdomains of 192.
struct GroupedCase {
  static constexpr std::uint32_t n = 128;
  static constexpr std::uint64_t most = 8000;  // so 4 groups of 32, halved for subdomains being many

  Whole w = whole_of(jittered_cube());
};

TEST(GraphPartition, GroupsDoNotDependOnTheNumberOfRanks) {
  const GroupedCase c;
  const auto expected = graph_parts(1, c.w, c.n, c.most);
  for (const int ranks : {2, 3, 4, 5, 6, 7, 8})
    EXPECT_EQ(graph_parts(ranks, c.w, c.n, c.most), expected) << ranks;
}

// METIS divides a single graph to 3 %, small groups by recursion to less, with less cut.
TEST(GraphPartition, GroupsAreBalancedAndCutLittleMore) {
  const GroupedCase c;
  const auto whole = graph_parts(2, c.w, c.n, c.w.work.size()), grouped = graph_parts(2, c.w, c.n, c.most);
  EXPECT_LT(interface_area(c.w, grouped), 1.03 * interface_area(c.w, whole));
  for (const double load : loads(c.w, grouped, c.n)) EXPECT_NEAR(load, 192, 3);
}

TEST(GraphPartition, GroupsAreEnoughForManyRanks) {
  const GroupedCase c;
  std::size_t of_one_graph = 0, of_groups = 0, of_few_subdomains = 0;
  graph_parts(8, c.w, c.n, c.w.work.size(), &of_one_graph);
  graph_parts(8, c.w, c.n, c.most, &of_groups);
  graph_parts(8, c.w, c.n / 2, c.most, &of_few_subdomains);
  EXPECT_LT(of_groups, of_one_graph / 7);
  EXPECT_GT(of_few_subdomains, of_one_graph / 5);  // 16 subdomains a group are not halved
}

TEST(GraphPartition, ManySubdomainsOfOneGraphAreDealtToSeveralRanks) {
  const GroupedCase c;
  constexpr std::uint32_t many = 2 * c.n;
  const std::size_t all = c.w.work.size();
  std::size_t of_few = 0, of_many = 0;
  const double area = interface_area(c.w, graph_parts(8, c.w, c.n, all, &of_few));
  const auto expected = graph_parts(8, c.w, many, all, &of_many);
  EXPECT_LT(of_many, 0.6 * static_cast<double>(of_few));
  EXPECT_LT(interface_area(c.w, expected), 1.3 * area);  // the cube root of 2, and the plane
  for (const double load : loads(c.w, expected, many)) EXPECT_NEAR(load, 96, 5);
  EXPECT_EQ(graph_parts(3, c.w, many, all), expected);
}

TEST(DualGraph, JoinsTetsAtTheFaceTheyShare) {
  // Two tets at face 1 2 3, a third one at face 0 1 2 of the first, a fourth alone.
  const std::vector<DualVertex> tets{{0, 1, {0, 1, 2, 3}, {0.8F, 0, 0, 0}},
                                     {1, 1, {4, 3, 2, 1}, {0.4F, 9, 9, 9}},
                                     {2, 1, {2, 5, 0, 1}, {9, NAN, 9, 9}},
                                     {3, 1, {6, 7, 8, 9}, {9, 9, 9, 9}}};
  const DualGraph g = dual_graph(tets);
  EXPECT_THAT(g.begins, ::testing::ElementsAre(0, 2, 3, 4, 4));
  EXPECT_THAT(g.neighbours, ::testing::UnorderedElementsAre(1, 2, 0, 0));
  const double unit = std::sqrt(3) / 4;
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(g.face_weights[i], g.neighbours[i] == 1 ? 0.5 + 0.6 / (2 * unit) : 0.5, 1e-6);
  EXPECT_EQ(g.face_weights[2] + g.face_weights[3], g.face_weights[0] + g.face_weights[1]);
}

TEST(GraphPartition, DividesAMeshOfUnconnectedTets) {
  Whole w;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Point p{static_cast<double>(i), 0, 0};
    w.centres.push_back(p);
    w.corners.push_back({p, p, p, p});
    w.vertices.push_back({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
  }
  w.work.assign(200, 1);
  w.cut_tensors.assign(200, meshing::identity_tensor());
  w.face_areas.resize(200);
  w.complexities.resize(200);
  for (const std::uint32_t n : {4u, 12u})
    for (const double load : loads(w, decompose_on(2, w, n, "graph"), n)) EXPECT_NEAR(load, 200.0 / n, 2);
}

}  // namespace
}  // namespace weft::partition::decomposition_test

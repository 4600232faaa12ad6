// Surfaces that cross themselves or are open become the boundary of what they go around.
#include "meshing/initial/mending/resolve_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/initial/clean_triangles.h"
#include "meshing/initial/closed_surface.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/mending/orient_triangles.h"
#include "meshing/initial/mending/split_crossings.h"
#include "meshing/initial/mending/winding_number.h"
#include "meshing/initial/repair_surface.h"
#include "meshing/initial/self_intersections.h"
#include "tests/meshing/initial/initial_support.h"

namespace weft::meshing::resolve_surface_test {
namespace {

using support::ball;
using support::box_surface;
using support::enclosed_volume;
using support::together;

MeshData turned(MeshData m) {
  for (auto& t : m.triangles) std::swap(t[0], t[1]);
  return m;
}

/// Mended, it passes the check of every surface, and encloses this.
void expect_volume(MeshData m, double volume, double tolerance = 1e-12) {
  EXPECT_THROW(close_surface(m, {}), InputError);
  EXPECT_FALSE(repair_surface(m).empty());
  ASSERT_NO_THROW(close_surface(m, {}));
  EXPECT_NEAR(enclosed_volume(m), volume, tolerance);
}

const MeshData kBox = box_surface({0, 0, 0}, {1, 1, 1}, 3);

TEST(ResolveSurface, TwoBoxesThatCrossAreOne) {
  expect_volume(together(kBox, box_surface({.5, .3, .2}, {1.6, 1.4, 1.3}, 2)), 1 + 1.331 - .5 * .7 * .8);
}

TEST(ResolveSurface, HoweverTheyAreOriented) {
  const MeshData other = box_surface({.5, .3, .2}, {1.6, 1.4, 1.3}, 2);
  expect_volume(together(kBox, turned(other)), 1 + 1.331 - .5 * .7 * .8);
  MeshData mixed = together(kBox, other);
  for (std::size_t i = 0; i < mixed.triangles.size(); i += 3)
    std::swap(mixed.triangles[i][0], mixed.triangles[i][1]);
  expect_volume(mixed, 1 + 1.331 - .5 * .7 * .8);
}

TEST(ResolveSurface, BoxesWithSidesInCommonPlanes) {
  expect_volume(together(kBox, box_surface({.5, 0, .2}, {1.6, 1, 1}, 2)), 1 + .6 * .8);
  expect_volume(together(kBox, box_surface({.25, .25, 1}, {.5, .5, 2}, 1)), 1 + .0625);
}

TEST(ResolveSurface, AHollowBodyStaysHollow) {
  const MeshData hollow = together(kBox, box_surface({.25, .25, .25}, {.75, .75, .75}, 2));
  expect_volume(together(hollow, box_surface({.9, .4, .4}, {1.6, .6, .6}, 1)), 1 - .125 + .6 * .04);
}

TEST(ResolveSurface, ManyBallsInAHeap) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(0, 1);
  MeshData heap;
  for (int i = 0; i < 7; ++i) {
    const Point centre = {at(random), 0.3 * at(random), 0.3 * at(random)};
    const MeshData one = ball(0.2, centre, 0.3);
    heap = together(std::move(heap), i % 3 == 0 ? turned(one) : one);
  }
  ASSERT_THROW(close_surface(heap, {}), InputError);
  MeshData mended = heap;
  std::string left;
  repair_surface(mended, &left);
  EXPECT_EQ(left, "");
  ASSERT_NO_THROW(close_surface(mended, {}));
  // The share of random points that the union holds.
  int inside = 0;
  constexpr int kTrials = 4000;
  std::vector<std::int32_t> once(heap.triangles.size(), 1), all(mended.triangles.size(), 1);
  const WindingNumber winding(mended.points, mended.triangles, all);
  for (int i = 0; i < kTrials; ++i) {
    const Point p = {1.6 * at(random) - .3, .9 * at(random) - .3, .9 * at(random) - .3};
    inside += winding.at(p) > 0.5;
  }
  EXPECT_NEAR(enclosed_volume(mended) / (1.6 * .9 * .9), double(inside) / kTrials, 0.03);
}

TEST(ResolveSurface, ABoxWithoutALidGetsOne) {
  MeshData open = kBox;
  open.triangles.resize(open.triangles.size() - 18);
  open.triangle_refs.resize(open.triangles.size());
  MeshData mended = open;
  const MeshMend mend = repair_surface(mended).back();
  EXPECT_EQ(mend.what, "triangles made across openings");
  EXPECT_EQ(mend.unit, "distance");
  EXPECT_NEAR(mend.amount, 0.5, 0.2);
  expect_volume(open, 1);
  expect_volume(turned(open), 1);
}

TEST(ResolveSurface, ASheetStaysOpen) {
  MeshData sheet = kBox;
  sheet.triangles.resize(18);
  sheet.triangle_refs.resize(18);
  std::string left;
  repair_surface(sheet, &left);
  EXPECT_EQ(left, "no triangle bounds a volume");
  EXPECT_EQ(sheet.triangles.size(), 18u);
  EXPECT_THROW(close_surface(sheet, {}), InputError);
}

TEST(ResolveSurface, TheVoidBetweenShellsIsNoVolume) {
  // Four bars around a square hole.
  MeshData frame = together(box_surface({0, 0, 0}, {3, 1, 1}, 1), box_surface({0, 2, 0}, {3, 3, 1}, 1));
  frame = together(frame, box_surface({0, 0.5, 0.1}, {1, 2.5, 0.9}, 1));
  frame = together(frame, box_surface({2, 0.5, 0.1}, {3, 2.5, 0.9}, 1));
  expect_volume(frame, 6 + 2 * 1 * 1 * 0.8);
}

/// A box and a small triangle with a corner there, listed so that it turns against its corners' numbers.
MeshData with_loose_triangle(const Point& corner) {
  MeshData m = kBox;
  const auto n = static_cast<std::uint32_t>(m.points.size());
  m.points.insert(m.points.end(), {corner, corner - Point{0.01, 0, 0}, corner - Point{0, 0.01, 0}});
  m.point_refs.resize(n + 3);
  m.triangles.push_back({n, n + 2, n + 1});
  m.triangle_refs.push_back(7);
  return m;
}

TEST(RepairSurface, ALooseTriangleBoundsNothing) {
  for (const Point& corner : {Point{0.3, 0.4, 2}, Point{0.3, 0.4, 0.5}, Point{0, 0, 0}}) {
    MeshData m = with_loose_triangle(corner);
    expect_volume(m, 1);
    repair_surface(m);
    EXPECT_EQ(m.triangles.size(), kBox.triangles.size());
  }
}

TEST(RepairSurface, ListsRequiredTrianglesByTheirNewNumbers) {
  MeshData m = kBox;
  m.triangles.insert(m.triangles.begin(), {m.triangles[5], m.triangles[7]});  // 7 and 9 repeat these
  m.triangle_refs.insert(m.triangle_refs.begin(), 2, 1);
  m.required_triangles = {7, 20};
  const Triangle was = m.triangles[20];
  std::array<Point, 3> places;
  for (std::size_t k = 0; k < 3; ++k) places[k] = m.points[was[k]];
  std::vector<std::uint32_t> source;
  repair_surface(m, nullptr, nullptr, &source);
  ASSERT_EQ(m.required_triangles, (std::vector<std::uint32_t>{0, 18}));
  ASSERT_EQ(source.size(), m.triangles.size());
  EXPECT_EQ(source[7], 8u);
  EXPECT_EQ(source[18], 20u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(m.points[m.triangles[18][k]], places[k]);
}

TEST(RepairSurface, PiecesOfARequiredTriangleAreRequired) {
  MeshData crossing = together(kBox, box_surface({.5, .3, .2}, {1.6, 1.4, 1.3}, 2));
  for (std::uint32_t t = 0; t < crossing.triangles.size(); ++t) crossing.required_triangles.push_back(t);
  repair_surface(crossing);
  EXPECT_EQ(crossing.required_triangles.size(), crossing.triangles.size());
}

/// The 12 edges of a box of n squares a side, in n pieces each: references from `first_ref` on, every second
/// edge a ridge, every third required.
void list_edges_of_box(const Point& lo, const Point& hi, std::int32_t first_ref, MeshData& m) {
  std::int32_t ref = first_ref;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner, ++ref) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      std::set<std::pair<double, std::uint32_t>> along;
      for (const Triangle& t : m.triangles)
        for (const std::uint32_t p : t) {
          const Point& x = m.points[p];
          if (x[u] == (corner & 1 ? hi : lo)[u] && x[v] == (corner & 2 ? hi : lo)[v] && x[axis] >= lo[axis] &&
              x[axis] <= hi[axis])
            along.emplace(x[axis], p);
        }
      std::map<double, std::uint32_t> at(along.begin(), along.end());
      for (auto next = std::next(at.begin()); next != at.end(); ++next) {
        const auto e = static_cast<std::uint32_t>(m.edges.size());
        m.edges.push_back({std::prev(next)->second, next->second});
        m.edge_refs.push_back(ref);
        if (ref % 2 == 0) m.ridges.push_back(e);
        if (ref % 3 == 0) m.required_edges.push_back(e);
      }
    }
}

/// The lengths of listed edges that are edges of triangles, by reference; ridges and required ones must be
/// those of the right references.
std::map<std::int32_t, double> lengths_by_ref(const MeshData& m) {
  std::set<std::uint64_t> of_triangles;
  for (const Triangle& t : m.triangles)
    for (std::size_t k = 0; k < 3; ++k) of_triangles.insert(edge_key(t[k], t[(k + 1) % 3]));
  std::map<std::int32_t, double> lengths;
  std::vector<std::uint32_t> ridges, required;
  for (std::uint32_t e = 0; e < m.edges.size(); ++e) {
    const auto& [a, b] = m.edges[e];
    if (of_triangles.contains(edge_key(a, b))) lengths[m.edge_refs[e]] += norm(m.points[a] - m.points[b]);
    if (m.edge_refs[e] % 2 == 0) ridges.push_back(e);
    if (m.edge_refs[e] % 3 == 0) required.push_back(e);
  }
  EXPECT_EQ(m.ridges, ridges);
  EXPECT_EQ(m.required_edges, required);
  return lengths;
}

TEST(ResolveSurface, PiecesOfListedEdgesStayListed) {
  const Point lo = {.5, .3, .2}, hi = {1.6, 1.4, 1.3};
  MeshData m = together(kBox, box_surface(lo, hi, 1));
  list_edges_of_box({0, 0, 0}, {1, 1, 1}, 0, m);
  list_edges_of_box(lo, hi, 100, m);
  repair_surface(m);
  ASSERT_NO_THROW(close_surface(m, {}));
  std::map<std::int32_t, double> lengths = lengths_by_ref(m);
  // Three edges of each box end where the other begins.
  const std::map<std::int32_t, double> cut = {{3, .5}, {7, .3}, {11, .2}, {100, .6}, {104, .4}, {108, .3}};
  for (const int first : {0, 100})
    for (std::int32_t ref = first; ref < first + 12; ++ref) {
      const double whole = first == 0 ? 1 : 1.1;
      EXPECT_NEAR(lengths[ref], cut.contains(ref) ? cut.at(ref) : whole, 1e-12) << ref;
    }
}

TEST(RepairSurface, HalvesOfAListedEdgeStayListed) {
  MeshData m = kBox;
  const auto [a, b, c] = m.triangles[0];
  const auto n = static_cast<std::uint32_t>(m.points.size());
  m.points.push_back(0.5 * (m.points[a] + m.points[b]));
  m.point_refs.push_back(0);
  m.triangles[0] = {a, n, c};  // its neighbour at this edge has it whole
  m.triangles.push_back({n, b, c});
  m.triangle_refs.push_back(m.triangle_refs[0]);
  m.edges = {{b, a}};
  m.edge_refs = {6};
  m.ridges = m.required_edges = {0};
  repair_surface(m);
  ASSERT_NO_THROW(close_surface(m, {}));
  EXPECT_EQ(m.edges.size(), 2u);
  EXPECT_NEAR(lengths_by_ref(m)[6], 1.0 / 3, 1e-12);
}

TEST(ResolveSurface, ALooseTriangleThatIsListedTwiceBoundsNothing) {
  MeshData m = with_loose_triangle({0.3, 0.4, 2});
  m.triangles.push_back(m.triangles.back());
  m.triangle_refs.push_back(7);
  std::vector<std::uint32_t> source(m.triangles.size());
  std::vector<MeshMend> mends;
  EXPECT_EQ(resolve_surface(m, source, mends), "");
  EXPECT_EQ(m.triangles.size(), kBox.triangles.size());
}

double total_area(const std::vector<Point>& p, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) sum += 0.5 * norm(cross(p[b] - p[a], p[c] - p[a]));
  return sum;
}

TEST(SplitCrossings, LeavesNoneInRandomHeaps) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    // Small whole coordinates: shared planes, edges through edges and vertices are the rule.
    std::vector<Point> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    while (triangles.size() < 12) {
      for (int k = 0; k < 3; ++k)
        points.push_back({double(random() % 5), double(random() % 5), double(random() % 5)});
      const auto n = static_cast<std::uint32_t>(points.size());
      const auto normal = cross(points[n - 2] - points[n - 3], points[n - 1] - points[n - 3]);
      if (norm2(normal) == 0)
        points.resize(n - 3);
      else
        triangles.push_back({n - 3, n - 2, n - 1});
    }
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (int round = 0; round < 10; ++round) {
      LooseTriangles loose{triangles, {}, {}, {}};
      loose.refs.resize(loose.size()), loose.source.resize(loose.size()),
          loose.sheets.assign(loose.size(), 1);
      TriangleCleaning cleaning(points, loose, 1e-9);
      cleaning.merge_points(), cleaning.drop_collapsed(), cleaning.mend_degenerate(),
          cleaning.merge_repeated();
      pairs = self_intersections(points, loose.corners, 1000);
      if (pairs.empty()) break;
      const double before = total_area(points, loose.corners);
      const SplitTriangles pieces = split_crossings(points, loose.corners, pairs);
      ASSERT_EQ(pieces.parent.size(), pieces.triangles.size());
      EXPECT_NEAR(total_area(pieces.points, pieces.triangles), before, 1e-9 * before);
      points = pieces.points;  // what crosses now does so by rounding, or repeats
      triangles = pieces.triangles;
    }
    EXPECT_TRUE(pairs.empty()) << "trial " << trial;
  }
}

TEST(SplitCrossings, CutsOneTriangleAlongManyOthers) {
  std::vector<Point> points = {{0, 0, 0}, {40, 0, 0}, {0, 40, 0}};
  std::vector<Triangle> triangles = {{0, 1, 2}};
  for (int i = 0; i < 19; ++i)
    for (int j = 0; j < 19; ++j) {
      const double x = i + 0.2, y = j + 0.3;
      const auto n = static_cast<std::uint32_t>(points.size());
      points.insert(points.end(), {{x, y, -1}, {x + 0.4, y + 0.1, -1}, {x + 0.2, y, 1}});
      triangles.push_back({n, n + 1, n + 2});
    }
  const auto pairs = self_intersections(points, triangles, 1000);
  ASSERT_EQ(pairs.size(), 361u);
  const SplitTriangles pieces = split_crossings(points, triangles, pairs);
  const double before = total_area(points, triangles);
  EXPECT_NEAR(total_area(pieces.points, pieces.triangles), before, 1e-12 * before);
  EXPECT_EQ(std::ranges::count(pieces.parent, 0u), 1 + 2 * 2 * 361);  // two more for each point inside
}

TEST(OrientTriangles, HolesOfAGroupStayHoles) {
  MeshData m = kBox;
  std::vector<std::array<std::uint32_t, 2>> crossings;  // they make it one group
  std::uint32_t last = 0;
  const auto add = [&](const Point& at, double size) {
    last = static_cast<std::uint32_t>(m.triangles.size());
    m = together(std::move(m), turned(box_surface(at, at + Point{size, size, size}, 1)));
    crossings.push_back({0, last});
  };
  for (int i = 0; i < 8; ++i) add({i & 1 ? .6 : .2, i & 2 ? .6 : .2, i & 4 ? .6 : .2}, 0.2);
  add({2, 0, 0}, 1);
  LooseTriangles loose{m.triangles, m.triangle_refs, {}, {}};
  loose.source.resize(loose.size()), loose.sheets.assign(loose.size(), 1);
  TriangleCleaning(m.points, loose, 1e-9).merge_points();
  const std::vector<bool> turned = orient_triangles(m.points, loose, crossings);
  for (std::uint32_t t = 0; t < turned.size(); ++t) EXPECT_EQ(turned[t], t >= last) << t;
}

/// Two halves of a box whose middle they divide differently, apart by a little: the seam is joined where
/// vertices are near each other, triangles split where they are not.
TEST(RepairSurface, JoinsASeamAndItsJunctions) {
  const auto without = [](MeshData m, std::int32_t ref) {
    MeshData kept = m;
    kept.triangles.clear(), kept.triangle_refs.clear();
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
      if (m.triangle_refs[t] != ref) {
        kept.triangles.push_back(m.triangles[t]);
        kept.triangle_refs.push_back(m.triangle_refs[t]);
      }
    return kept;
  };
  const MeshData left = without(box_surface({0, 0, 0}, {1, 1, 1}, 4), 2),
                 right = without(box_surface({1.0001, 0, 0}, {2, 1, 1}, 12), 1);
  MeshData m = together(left, right);
  std::vector<std::string> what;
  for (const MeshMend& mend : repair_surface(m)) what.push_back(mend.what);
  EXPECT_NE(std::ranges::find(what, "vertices joined across seams"), what.end());
  EXPECT_NE(std::ranges::find(what, "triangles split at vertices beside their free edges"), what.end());
  ASSERT_NO_THROW(close_surface(m, {}));
  EXPECT_NEAR(enclosed_volume(m), 2, 1e-3);
}

TEST(RepairSurface, EndsWhereItIsInterrupted) {
  MeshData crossing = together(kBox, box_surface({.5, .5, .5}, {2, 2, 2}, 4));
  const std::atomic<bool> interrupt{true};
  EXPECT_THROW(repair_surface(crossing, nullptr, &interrupt), Interrupted);
}

TEST(WindingNumber, CountsTheWaysAround) {
  const MeshData two = together(kBox, box_surface({-1, -1, -1}, {2, 2, 2}, 4));
  const std::vector<std::int32_t> once(two.triangles.size(), 1);
  const WindingNumber winding(two.points, two.triangles, once);
  EXPECT_NEAR(winding.at({.5, .4, .6}), 2, 0.02);
  EXPECT_NEAR(winding.at({1.5, 1.5, 1.6}), 1, 0.02);
  EXPECT_NEAR(winding.at({3, 1, 1}), 0, 0.02);
  const auto& [a, b, c] = two.triangles[5];
  const Point middle = (1.0 / 3) * (two.points[a] + two.points[b] + two.points[c]);
  EXPECT_NEAR(winding.at(middle, 5), 1.5, 0.02);
}

}  // namespace
}  // namespace weft::meshing::resolve_surface_test

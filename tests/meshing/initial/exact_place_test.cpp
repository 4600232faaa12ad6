// Places on edges and facets lie there exactly, which rounded points do not.
#include "meshing/initial/grid/exact_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing::exact_place_test {
namespace {

class ExactPlaces : public ::testing::Test {
 protected:
  Point point() { return {at_(random_), at_(random_), at_(random_)}; }
  ExactPlace plain() { return ExactPlace::at(point()); }
  static int side(const Point& a, const Point& b, const Point& c, const ExactPlace& d) {
    return orientation(ExactPlace::at(a), ExactPlace::at(b), ExactPlace::at(c), d);
  }

  std::mt19937 random_{1};
  std::uniform_real_distribution<double> at_{-1, 1};
  static constexpr int kTimes = 500;
};

TEST_F(ExactPlaces, OnAnEdgeLieInEveryPlaneThroughIt) {
  for (int i = 0; i < kTimes; ++i) {
    const Point a = point(), b = point();
    const ExactPlace p = place_on_edge(a, b, {plain(), plain(), plain()});
    EXPECT_EQ(side(a, b, point(), p), 0);
  }
}

TEST_F(ExactPlaces, OnAnEdgeMeetThePlaneToFourTimesThePrecision) {
  for (int i = 0; i < kTimes; ++i) {
    const Point a = point(), b = point(), x = point(), y = point(), z = point();
    const ExactPlace p = place_on_edge(a, b, {ExactPlace::at(x), ExactPlace::at(y), ExactPlace::at(z)});
    ExactPlace before = p, after = p;
    const double step = 1e-58 * std::abs(p.s.terms[0]);
    before.s.terms[3] -= step;
    after.s.terms[3] += step;
    EXPECT_EQ(side(x, y, z, before) * side(x, y, z, after), -1);
  }
}

TEST_F(ExactPlaces, OnAFacetLieInItsPlaneAndOnTheLine) {
  for (int i = 0; i < kTimes; ++i) {
    const Point a = point(), b = point(), c = point(), from = point(), to = point();
    const ExactPlace p = place_on_facet({a, b, c}, ExactPlace::at(from), ExactPlace::at(to));
    EXPECT_EQ(side(a, b, c, p), 0);
    const Vec way = to - from, gap = p.rounded() - from;
    EXPECT_LT(norm(cross(way, gap)), 1e-13 * norm(way) * (norm(gap) + norm(p.rounded()) + 1));
  }
}

TEST_F(ExactPlaces, AGridOrientsThemExactlyHoweverNearTheyAreToThePlane) {
  for (int i = 0; i < kTimes; ++i) {
    const Point a = point(), b = point(), c = point();
    TetGrid grid;
    for (const Point& p : {a, b, c, Point{}}) grid.add_point(p);
    ExactPlace on = place_on_facet({a, b, c}, plain(), plain());
    grid.place_exactly(3, on);
    EXPECT_EQ(grid.orient(0, 1, 2, 3), 0);
    for (const double step : {1e-30, 1e-16, 1e-12, 1e-3}) {
      const double off = std::ldexp(1.0, std::ilogb(step));
      ExactPlace above = on;  // the facet's plane turned about its first corner
      above.u = a + (1 + off) * (b - a) + off * cross(b - a, c - a);
      grid.place_exactly(3, above);
      EXPECT_EQ(grid.orient(0, 1, 2, 3),
                orientation(ExactPlace::at(a), ExactPlace::at(b), ExactPlace::at(c), above));
    }
  }
}

TEST_F(ExactPlaces, OrientLikePlainPoints) {
  for (int i = 0; i < kTimes; ++i) {
    const Point a = point(), b = point(), c = point(), d = point();
    EXPECT_EQ(side(a, b, c, ExactPlace::at(d)), six_volume(a, b, c, d) > 0 ? 1 : -1);
  }
}

}  // namespace
}  // namespace weft::meshing::exact_place_test

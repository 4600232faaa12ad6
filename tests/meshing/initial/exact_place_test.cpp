// Places on edges and facets lie there exactly, which rounded points do not.
#include "meshing/initial/grid/exact_place.h"

#include <gtest/gtest.h>

#include <random>

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

TEST_F(ExactPlaces, OrientLikePlainPoints) {
  for (int i = 0; i < kTimes; ++i) {
    const Point a = point(), b = point(), c = point(), d = point();
    EXPECT_EQ(side(a, b, c, ExactPlace::at(d)), six_volume(a, b, c, d) > 0 ? 1 : -1);
  }
}

}  // namespace
}  // namespace weft::meshing::exact_place_test

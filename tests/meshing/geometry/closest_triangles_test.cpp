// The closest of many triangles: against each of them alone, and whatever the sets.
#include "meshing/geometry/surface/closest_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

namespace weft::meshing::closest_triangles_test {
namespace {

using Triangle = ClosestTriangles::Triangle;
using Found = ClosestTriangles::Found;

/// On a coarse lattice, so that many are equally near; with some of no area. By quarters all is exact.
std::vector<Triangle> triangles_on_lattice(std::uint64_t count, std::mt19937& random) {
  std::uniform_int_distribution<int> place(-4, 4);
  const auto point = [&] { return Point{place(random) / 4.0, place(random) / 4.0, place(random) / 4.0}; };
  std::vector<Triangle> triangles;
  for (std::uint64_t number = 0; number < count; ++number) {
    const Point a = point();
    triangles.push_back({number, {a, point(), number % 10 == 3 ? a : point()}});
  }
  std::shuffle(triangles.begin(), triangles.end(), random);
  return triangles;
}

std::vector<Point> some_points(std::mt19937& random) {
  std::uniform_int_distribution<int> place(-6, 6);
  std::uniform_real_distribution<double> anywhere(-3, 3);
  std::vector<Point> points;
  for (int i = 0; i < 100; ++i) {
    points.push_back({place(random) / 4.0, place(random) / 4.0, place(random) / 4.0});
    points.push_back({anywhere(random), anywhere(random), anywhere(random)});
  }
  return points;
}

void expect_same(const Found& found, const Found& expected) {
  EXPECT_EQ(found.distance2, expected.distance2);
  EXPECT_EQ(found.number, expected.number);
  EXPECT_EQ(found.way, expected.way);
}

TEST(ClosestTriangles, IsTheFirstOfTheNearestWhateverTheSets) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    const std::vector<Triangle> all = triangles_on_lattice(40, random);
    const std::size_t cut = random() % all.size();
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(cut);
    const ClosestTriangles whole(all), front({all.begin(), middle}), back({middle, all.end()});
    for (const Point& p : some_points(random)) {
      Found expected;
      for (const Triangle& triangle : all) {
        const Found one = ClosestTriangles({triangle}).closest(p);
        if (one.before(expected)) expected = one;
      }
      expect_same(whole.closest(p), expected);
      const Found a = front.closest(p), b = back.closest(p, a.distance2);
      expect_same(b.before(a) ? b : a, expected);
      EXPECT_NEAR(norm2(expected.way), expected.distance2, 1e-12);
    }
  }
}

TEST(ClosestTriangles, FindsWhatIsAtTheLimitAndNothingBeyond) {
  const ClosestTriangles triangle({{7, {Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}}}});
  expect_same(triangle.closest({0.25, 0.25, 2}), {4, 7, {0, 0, 2}});
  expect_same(triangle.closest({0.25, 0.25, 2}, 4), {4, 7, {0, 0, 2}});
  expect_same(triangle.closest({0.25, 0.25, 2}, 3.9), {3.9, ClosestTriangles::kNone, {}});
  expect_same(triangle.closest({-3, 0, -4}), {25, 7, {-3, 0, -4}});
  expect_same(ClosestTriangles({}).closest({1, 2, 3}), {});
}

TEST(ClosestTriangles, TakesThoseOfTwoEqualCornersAsEdges) {
  const Point a{0, 0, 0}, b{2, 0, 0};
  for (const std::array<Point, 3>& corners :
       {std::array{a, a, b}, {a, b, a}, {b, a, a}, {b, b, a}, {b, a, b}, {a, b, b}}) {
    const ClosestTriangles triangle({{3, corners}});
    expect_same(triangle.closest({1, 1, 0}), {1, 3, {0, 1, 0}});
    expect_same(triangle.closest({4, 0, 0}), {4, 3, {2, 0, 0}});
    expect_same(triangle.closest({-1, 0, 0}), {1, 3, {-1, 0, 0}});
  }
}

TEST(ClosestTriangles, HasFewBoxesAroundAllOfThem) {
  std::mt19937 random(5);
  const std::vector<Triangle> all = triangles_on_lattice(300, random);
  for (const std::size_t most : {1u, 3u, 16u, 1000u}) {
    const std::vector<Box> boxes = ClosestTriangles(all).boxes(most);
    EXPECT_LE(boxes.size(), most);
    EXPECT_GT(2 * boxes.size(), std::min<std::size_t>(most, 75)) << "leaves have four or fewer";
    for (const Triangle& triangle : all)
      EXPECT_TRUE(std::ranges::any_of(boxes, [&](const Box& box) {
        return std::ranges::all_of(triangle.corners, [&](const Point& p) { return box.distance2(p) == 0; });
      }));
  }
  EXPECT_TRUE(ClosestTriangles({}).boxes(4).empty());
}

}  // namespace
}  // namespace weft::meshing::closest_triangles_test

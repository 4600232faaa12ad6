// Names of triangles in runs, against a name for each.
#include "meshing/io/cgns_triangle_names.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/support/repetitions.h"

namespace weft::meshing::cgns {
namespace {

struct Named {
  std::int64_t element;
  std::uint32_t name;
};

void expect_same(const TriangleNames& names, const std::vector<Named>& expected) {
  std::uint64_t next = 0;
  names.for_each_run([&](std::uint64_t begin, std::uint64_t end, std::uint32_t name) {
    EXPECT_EQ(begin, next);
    EXPECT_LT(begin, end);
    for (std::uint64_t t = begin; t < end; ++t) EXPECT_EQ(expected.at(t).name, name) << t;
    next = end;
  });
  EXPECT_EQ(next, expected.size());
}

TEST(CgnsTriangleNames, AreThoseOfTheLastConditionOfEach) {
  for (unsigned seed = 1; seed <= support::repetitions(300, 3000); ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](unsigned n) { return static_cast<std::int64_t>(random() % n); };
    TriangleNames names;
    std::vector<Named> expected;
    // Sections in any order of their elements, some of which are not triangles.
    std::vector<std::int64_t> starts = {1, 20, 40, 60};
    std::ranges::shuffle(starts, random);
    for (std::uint32_t s = 0; s < starts.size(); ++s)
      for (std::int64_t element = starts[s] + below(3); element < starts[s] + 15;
           element += 1 + below(4) / 3) {
        names.add(element, 1, s);
        expected.push_back({element, s});
      }
    for (std::uint32_t name = 10; name < 16; ++name) {
      const std::int64_t first = below(80) - 2, last = first + below(30) - 1;  // some of none
      names.rename(first, last, name % 4 + 2);  // the same again, or as a section
      for (Named& triangle : expected)
        if (triangle.element >= first && triangle.element <= last) triangle.name = name % 4 + 2;
    }
    expect_same(names, expected);
  }
}

TEST(CgnsTriangleNames, OfElementsThatNoFileHasAreNone) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max(), least = -most - 1;
  TriangleNames names;
  names.rename(least, most, 7);
  expect_same(names, {});
  names = {};
  names.add(most - 3, 4, 1);
  names.rename(most - 1, most, 2);
  names.rename(most, least, 3);
  names.rename(least, 0, 4);
  expect_same(names, {{most - 3, 1}, {most - 2, 1}, {most - 1, 2}, {most, 2}});
}

TEST(CgnsTriangleNames, TakeNoMoreRunsThanTheyHave) {
  TriangleNames names;
  names.add(1, 1000, 0);
  for (std::int64_t element = 800; element >= 200; --element) names.rename(element, element, 1);
  for (std::int64_t element = 400; element <= 600; ++element) names.rename(element, element, 0);
  int runs = 0;
  names.for_each_run([&](std::uint64_t, std::uint64_t, std::uint32_t) { ++runs; });
  EXPECT_EQ(runs, 5);
}

}  // namespace
}  // namespace weft::meshing::cgns

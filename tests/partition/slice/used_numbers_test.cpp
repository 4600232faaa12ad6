// The points of tets, dense and far apart.
#include "partition/slice/used_numbers.h"

#include <gtest/gtest.h>

#include <vector>

namespace weft::partition::used_numbers_test {
namespace {

using Numbers = std::vector<std::uint32_t>;

TEST(UsedNumbers, AreAscendingAndEachOnce) {
  EXPECT_EQ(used_numbers({}), Numbers());
  const std::vector<meshing::Tet> dense{{7, 5, 9, 6}, {9, 6, 7, 12}};
  EXPECT_EQ(used_numbers(dense), Numbers({5, 6, 7, 9, 12}));
  const std::vector<meshing::Tet> sparse{{4000000000u, 5, 0xFFFFFFFFu, 6}, {0, 6, 5, 4000000000u}};
  EXPECT_EQ(used_numbers(sparse), Numbers({0, 5, 6, 4000000000u, 0xFFFFFFFFu}));
}

TEST(UsedNumbers, AreTheSameOnBothSidesOfTheLimitOfMarks) {
  for (const std::uint32_t farthest : {126u, 127u, 128u, 129u})
    EXPECT_EQ(used_numbers(std::vector<meshing::Tet>{{farthest, 3, 0, 2}}), Numbers({0, 2, 3, farthest}));
}

}  // namespace
}  // namespace weft::partition::used_numbers_test

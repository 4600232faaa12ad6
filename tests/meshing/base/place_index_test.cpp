// Places in a sorted list: those of a search of all of it.
#include "meshing/base/place_index.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "meshing/base/sort_unique.h"

namespace weft::meshing::place_index_test {
namespace {

void expect_places(const std::vector<std::uint32_t>& numbers) {
  const PlaceIndex place(numbers);
  for (std::uint32_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(place(numbers[i]), i) << numbers[i];
}

TEST(PlaceIndex, FindsTheEndsOfTheRangeOfNumbers) {
  expect_places({});
  expect_places({0});
  expect_places({0xFFFFFFFFu});
  expect_places({0, 0xFFFFFFFFu});
  expect_places({0, 1, 2, 3, 0x80000000u, 0xFFFFFFFEu, 0xFFFFFFFFu});
}

TEST(PlaceIndex, FindsNumbersInRunsAndAlone) {
  std::mt19937 random(5);
  for (const std::uint32_t gap : {1u, 3u, 1000u, 1000000u}) {
    std::vector<std::uint32_t> numbers;
    for (int run = 0; run < 50; ++run) {
      const std::uint32_t first = random() % (50 * gap);
      for (std::uint32_t i = 0; i < random() % 40; ++i) numbers.push_back(first + i);
    }
    sort_unique(numbers);
    expect_places(numbers);
  }
}

}  // namespace
}  // namespace weft::meshing::place_index_test

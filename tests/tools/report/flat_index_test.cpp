// Numbers are given in the order in which keys are first met, however many there are.
#include "tools/report/flat_index.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace weft::report::flat_index_test {
namespace {

/// Against std::map, with `values` different values of each integer and room for `expected` keys.
template <class Integer, std::size_t kSize>
void check(Integer values, std::size_t expected) {
  std::mt19937 random(values);
  std::uniform_int_distribution<int> value(0, static_cast<int>(values) - 1);
  FlatIndex<Integer, kSize> index(expected);
  std::map<std::array<Integer, kSize>, std::uint32_t> known;
  for (int i = 0; i < 20'000; ++i) {
    std::array<Integer, kSize> key;
    for (Integer& k : key) k = static_cast<Integer>(value(random) - 3);
    const auto number = known.try_emplace(key, static_cast<std::uint32_t>(known.size())).first->second;
    ASSERT_EQ(index.number_of(key), number);
    ASSERT_EQ(index.size(), known.size());
  }
}

TEST(FlatIndex, NumbersKeysAsTheyAreMet) {
  check<std::uint32_t, 3>(20, 8000);
  check<std::int32_t, 3>(200, 20'000);  // nearly all are new
  check<std::uint16_t, 3>(30, 20'000);
  check<std::uint32_t, 1>(5000, 5000);
}

TEST(FlatIndex, TakesMoreThanWasExpected) {
  check<std::uint32_t, 3>(200, 0);
  check<std::uint32_t, 1>(5000, 10);
}

}  // namespace
}  // namespace weft::report::flat_index_test

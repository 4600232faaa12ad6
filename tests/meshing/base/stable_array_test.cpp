// Arrays that fill without moving.
#include "meshing/base/stable_array.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace weft::meshing {
namespace {

TEST(StableArray, WhatIsClearedReadsAsZeroAndTheRestStays) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    const std::size_t capacity = 1 + random() % 20000, used = random() % (capacity + 1);
    const std::size_t size = used - random() % (used + 1) / (1 + random() % 8);
    SCOPED_TRACE(testing::Message() << size << " of " << used << " of " << capacity);
    StableArray<std::uint32_t> array(capacity, Pages::small);
    for (std::uint32_t i = 0; i < used; ++i) array[i] = i + 1;
    array.clear_from(size, used);
    for (std::uint32_t i = 0; i < capacity; ++i) ASSERT_EQ(array[i], i < size ? i + 1 : 0) << i;
  }
}

TEST(StableArray, NothingIsClearedWhereNoneWasUsedBehind) {
  StableArray<std::uint64_t> array(100);
  for (std::uint32_t i = 0; i < 100; ++i) array[i] = i + 1;
  array.clear_from(100, 100);
  array.clear_from(100, 50);
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(array[i], i + 1);
}

}  // namespace
}  // namespace weft::meshing

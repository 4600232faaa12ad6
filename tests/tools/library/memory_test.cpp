// Prediction of sizes, and the system's memory figures.
#include "tools/library/jobs/resources/memory.h"

#include <gtest/gtest.h>

namespace weft::tools::memory_test {
namespace {

TEST(PredictSize, GrowsWithComplexity) {
  const SizePrediction size = predict_size(1000, 10, 20);
  EXPECT_EQ(size.vertices, 2000);
  EXPECT_EQ(size.tets, 12000);
  EXPECT_EQ(size.bytes, 3e6);
}

TEST(PredictSize, IsNeverLessThanTheInput) {
  const SizePrediction size = predict_size(1, 1000, 6000);
  EXPECT_EQ(size.vertices, 1000);
  EXPECT_EQ(size.tets, 6000);
}

TEST(AvailableMemory, ReadsMeminfo) {
  EXPECT_EQ(parse_mem_available("MemTotal:  200 kB\nMemFree: 50 kB\nMemAvailable:    100 kB\n"), 102400);
  EXPECT_FALSE(parse_mem_available("MemTotal: 200 kB\n"));
}

TEST(AvailableMemory, ReadsTheControlGroup) {
  EXPECT_EQ(parse_cgroup_path("12:cpu:/other\n0::/user.slice/run\n"), "/user.slice/run");
  EXPECT_EQ(parse_cgroup_path("12:cpu:/other\n"), "");
}

TEST(AvailableMemory, IsKnownHere) {
  const auto room = available_memory();
  ASSERT_TRUE(room);
  EXPECT_GT(*room, 0);
  EXPECT_GT(peak_memory_bytes(), 1e6);
}

}  // namespace
}  // namespace weft::tools::memory_test

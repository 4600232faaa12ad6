// Prediction of sizes, and the system's memory figures.
#include "tools/library/jobs/resources/memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

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
  EXPECT_EQ(parse_cgroup_path("12:cpu,memory:/job:1\n0::/run\n", "memory"), "/job:1");
}

TEST(AvailableMemory, IsWhatTheTightestControlGroupLeaves) {
  const std::filesystem::path root =
      std::filesystem::temp_directory_path() / ("weft-groups-" + std::to_string(getpid()));
  const auto write = [&](const std::string& file, const std::string& text) {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text << "\n";
  };
  EXPECT_FALSE(control_group_room(root, "4:memory:/job/step\n0::/slice\n"));
  write("slice/memory.max", "max");
  write("slice/memory.current", "10");
  EXPECT_FALSE(control_group_room(root, "4:memory:/job/step\n0::/slice\n"));
  write("memory/job/memory.limit_in_bytes", "1000");
  write("memory/job/memory.usage_in_bytes", "700");
  write("memory/job/memory.stat", "cache 300\ntotal_inactive_file 100");
  EXPECT_EQ(control_group_room(root, "4:memory:/job/step\n0::/slice\n"), 400) << "of the group around it";
  write("slice/memory.max", "210");
  EXPECT_EQ(control_group_room(root, "4:memory:/job/step\n0::/slice\n"), 200);
  std::filesystem::remove_all(root);
}

TEST(RoomOfRank, IsKnownHere) {
  const auto room = room_of_rank(1, 0);
  ASSERT_TRUE(room);
  EXPECT_GT(*room, 0);
  EXPECT_EQ(room_of_rank(1, 1e6), 1e6);
  EXPECT_GT(peak_memory_bytes(), 1e6);
}

TEST(RoomOfRank, IsAShareOfTheMachineButAllThatTheProcessMayHave) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  statm >> pages;
  constexpr double kRoom = 64e6;
  rlimit limit = before;
  limit.rlim_cur = static_cast<rlim_t>(pages * static_cast<double>(sysconf(_SC_PAGESIZE)) + kRoom);
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  const auto room = room_of_rank(4, 0);
  setrlimit(RLIMIT_AS, &before);
  ASSERT_TRUE(room);
  EXPECT_GT(*room, kRoom / 2);
  EXPECT_LE(*room, kRoom);
}

TEST(RanksOnThisMachine, AreReadFromSlurmsList) {
  EXPECT_EQ(slurm_tasks_on("16", 0), 16);
  EXPECT_EQ(slurm_tasks_on("16(x2),8", 1), 16);
  EXPECT_EQ(slurm_tasks_on("16(x2),8", 2), 8);
  EXPECT_EQ(slurm_tasks_on("16(x2),8", 3), 0);
  EXPECT_EQ(slurm_tasks_on("", 0), 0);
  EXPECT_EQ(slurm_tasks_on("many", 0), 0);
}

}  // namespace
}  // namespace weft::tools::memory_test

// Loops over work of different sizes.
#include "meshing/base/parallel.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <vector>

namespace weft::meshing::parallel_test {
namespace {

TEST(ForEachLarge, AThreadBeginsNoOtherWhileItWaitsInOne) {
  constexpr std::size_t kTasks = 64;
  static thread_local int under_way = 0;
  std::atomic<int> most = 0;
  std::vector<std::atomic<std::size_t>> visits(kTasks);
  tbb::task_arena(4).execute([&] {
    for_each_large(kTasks, [&](std::size_t i) {
      ++under_way;
      for (int seen = most; seen < under_way && !most.compare_exchange_weak(seen, under_way);) {
      }
      for_each_index(20'000, [&](std::size_t) { ++visits[i]; });
      --under_way;
    });
  });
  EXPECT_EQ(most, 1);
  for (const auto& n : visits) EXPECT_EQ(n, 20'000u);
}

}  // namespace
}  // namespace weft::meshing::parallel_test

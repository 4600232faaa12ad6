// What subdomains have freed goes back to the system.
#include "graph/adaptation/freed_memory.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <vector>

#include "engine/base/blob.h"

namespace weft::graph::adaptation::freed_memory_test {
namespace {

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

double resident_bytes() {
  constexpr double kPage = 4096;
  double size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return kPage * resident;
}

TEST(FreedMemory, GivesBackBlocksThatAreKeptForMessages) {
  constexpr std::size_t kBlocks = 8, kBytes = std::size_t{1} << 20;
  std::vector<engine::Blob> blocks;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    blocks.push_back(engine::Blob::allocate(kBytes));
    std::memset(blocks.back().data(), 1, kBytes);
  }
  blocks.clear();
  const double before = resident_bytes();
  FreedMemory freed;
  freed.give_back();
  EXPECT_LT(resident_bytes(), before - 0.5 * kBlocks * kBytes);
}

#endif

}  // namespace
}  // namespace weft::graph::adaptation::freed_memory_test

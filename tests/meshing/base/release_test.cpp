// What is released, and what is freed, takes no memory.
#include "meshing/base/release.h"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <vector>

#include "meshing/base/freed_memory.h"

namespace weft::meshing::release_test {
namespace {

TEST(Release, GivesTheMemoryBack) {
  std::vector<int> values(1000, 1);
  release(values);
  EXPECT_EQ(values.capacity(), 0u);
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

double resident_pages() {
  double size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident;
}

// Between every two blocks that are freed there is one in use, so that none of them is at the end of the
// heap.
TEST(GiveBackFreedMemory, GivesBackWhatLiesBetweenBlocksInUse) {
  constexpr std::size_t kBlocks = 1000, kPagesOfBlock = 16, kBytesOfPage = 4096;
  std::vector<std::unique_ptr<std::vector<char>>> blocks, between;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    blocks.push_back(std::make_unique<std::vector<char>>(kPagesOfBlock * kBytesOfPage, 'x'));
    between.push_back(std::make_unique<std::vector<char>>(1, 'x'));
  }
  blocks.clear();
  const double before = resident_pages();
  give_back_freed_memory();
  EXPECT_LT(resident_pages(), before - 0.5 * kBlocks * kPagesOfBlock);
}

#endif

}  // namespace
}  // namespace weft::meshing::release_test

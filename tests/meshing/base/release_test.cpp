// What is released takes no memory.
#include "meshing/base/release.h"

#include <gtest/gtest.h>

#include <vector>

namespace weft::meshing::release_test {
namespace {

TEST(Release, GivesTheMemoryBack) {
  std::vector<int> values(1000, 1);
  release(values);
  EXPECT_EQ(values.capacity(), 0u);
}

}  // namespace
}  // namespace weft::meshing::release_test

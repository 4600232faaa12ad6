// Tests of assertions: the highest level, for this file alone.
#undef WEFT_ASSERTION_LEVEL
#define WEFT_ASSERTION_LEVEL 2
#include "meshing/base/assert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace weft::meshing::assert_test {
namespace {

TEST(Assert, SaysWhereAndWhatFailed) {
  const int two = 2;
  EXPECT_NO_THROW(WEFT_ASSERT_LIGHT(two == 2, "two is two"));
  try {
    WEFT_ASSERT_NORMAL(two == 3, "two is three");
    FAIL() << "nothing was thrown";
  } catch (const AssertionFailed& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("assert_test.cpp:"));
    EXPECT_THAT(e.what(), testing::HasSubstr("two is three (two == 3 does not hold)"));
  }
}

TEST(Assert, DoesNotEvaluateWhatIsBeyondTheLevel) {
  bool evaluated = false;
  WEFT_ASSERT_HEAVY((evaluated = true, false), "not asked for");
  EXPECT_FALSE(evaluated);
}

}  // namespace
}  // namespace weft::meshing::assert_test

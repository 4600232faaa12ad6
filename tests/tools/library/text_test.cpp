// Numbers as people read them.
#include "tools/common/text.h"

#include <gtest/gtest.h>

namespace weft::tools::text_test {
namespace {

TEST(Grouped, PutsCommasBetweenThousands) {
  EXPECT_EQ(grouped(std::uint64_t{0}), "0");
  EXPECT_EQ(grouped(std::uint64_t{999}), "999");
  EXPECT_EQ(grouped(std::uint64_t{1000}), "1,000");
  EXPECT_EQ(grouped(std::uint64_t{1234567}), "1,234,567");
  EXPECT_EQ(grouped(7622.6), "7,623");
  EXPECT_EQ(counted(1, "tet"), "1 tet");
  EXPECT_EQ(counted(1234, "tet"), "1,234 tets");
  EXPECT_EQ(counted(1, "vertex"), "1 vertex");
  EXPECT_EQ(counted(0, "vertex"), "0 vertices");
  EXPECT_EQ(grouped(1e20), "1e+20");
}

TEST(BytesText, ChoosesAUnit) {
  EXPECT_EQ(bytes_text(2e3), "2 kB");
  EXPECT_EQ(bytes_text(354e6), "354 MB");
  EXPECT_EQ(bytes_text(1.25e9), "1.2 GB");
  EXPECT_EQ(bytes_text(3e12), "3.0 TB");
}

TEST(SecondsText, ChoosesAUnit) {
  EXPECT_EQ(seconds_text(0.123), "0.12 s");
  EXPECT_EQ(seconds_text(22.04), "22.0 s");
  EXPECT_EQ(seconds_text(125), "2 min 05 s");
}

TEST(EditDistance, CountsChanges) {
  EXPECT_EQ(edit_distance("adapt", "adapt"), 0u);
  EXPECT_EQ(edit_distance("adpt", "adapt"), 1u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

}  // namespace
}  // namespace weft::tools::text_test

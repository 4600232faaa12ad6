// Parts of weft are found where a build has them; what is missing or of another version is told apart.
#include "meshing/base/load_part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "meshing/io/cgns_part.h"

namespace weft::meshing::load_part_test {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

constexpr const char* kFile = "libweft_cgns.so";

TEST(LoadPart, A_part_is_found_in_the_build) {
  const Part part = load_part(kFile, kCgnsEntryName, kCgnsInterface);
  ASSERT_TRUE(part.offer) << part.reason;
  EXPECT_EQ(load_part(kFile, kCgnsEntryName, kCgnsInterface).offer, part.offer);
  EXPECT_EQ(&cgns_part("m.cgns"), part.offer);
}

TEST(LoadPart, Another_version_is_refused) {
  for (const Part& part : {load_part(kFile, kCgnsEntryName, kCgnsInterface + 1),
                           load_part(kFile, "weft_no_such_entry", kCgnsInterface)}) {
    EXPECT_FALSE(part.offer);
    EXPECT_THAT(part.reason, EndsWith("libweft_cgns.so is of another version of weft"));
    EXPECT_THAT(missing_part_text(part, kFile, "CGNS", "libcgns3.4"), part.reason + ": install weft again");
  }
  EXPECT_THAT(missing_part_text({nullptr, "no libcgns.so.3.4"}, kFile, "CGNS", "libcgns3.4"),
              AllOf(HasSubstr("CGNS cannot be loaded (no libcgns.so.3.4)"), HasSubstr("libcgns3.4 (Debian")));
}

TEST(LoadPart, One_that_is_not_there_gives_no_reason) {
  const Part part = load_part("libweft_nothing.so", "weft_nothing", 1);
  EXPECT_FALSE(part.offer);
  EXPECT_EQ(part.reason, "");
  EXPECT_THAT(missing_part_text(part, "libweft_nothing.so", "nothing", "libnothing"),
              HasSubstr("libweft_nothing.so, a part of weft, is missing"));
}

}  // namespace
}  // namespace weft::meshing::load_part_test

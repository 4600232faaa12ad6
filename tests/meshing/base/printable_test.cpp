// What may reach a terminal: text of any language, and no byte that is not text.
#include "meshing/base/printable.h"

#include <gtest/gtest.h>

namespace weft::meshing::printable_test {
namespace {

TEST(Printable, LeavesTextOfAnyLanguage) {
  for (const char* text : {"", "wing.meshb", "Flügel", "крыло", "翼", "🛩"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, ReplacesWhatIsNoText) {
  EXPECT_EQ(printable("1\x98"
                      "0"),
            "1?0");
  EXPECT_EQ(printable("a\x1B[2Jb\n\x7F"), "a?[2Jb??");
  EXPECT_EQ(printable("\xC0\xAF"), "??");            // overlong
  EXPECT_EQ(printable("\xED\xA0\x80"), "???");       // half of a surrogate pair
  EXPECT_EQ(printable("\xF4\x90\x80\x80"), "????");  // beyond Unicode
  EXPECT_EQ(printable("\xC2\x9B"
                      "1m"),
            "??1m");                           // CSI as a control character of two bytes
  EXPECT_EQ(printable("ab\xE7\xBF"), "ab??");  // cut short
}

}  // namespace
}  // namespace weft::meshing::printable_test

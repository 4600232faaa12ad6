// The peers' option words.
#include "tools/weft/options/arguments.h"

#include <gtest/gtest.h>

namespace weft::tools::arguments_test {
namespace {

using Words = std::vector<std::string>;

TEST(TranslateAliases, KnowsThePeersWords) {
  EXPECT_EQ(translate_aliases(
                {"adapt", "a.meshb", "-met", "m.solb", "-out", "b.meshb", "-hgrad", "-1", "-ar", "30"}),
            (Words{"adapt", "a.meshb", "--metric", "m.solb", "--out", "b.meshb", "--hgrad", "-1",
                   "--ridge-angle", "30"}));
  EXPECT_EQ(translate_aliases({"-in", "a.mesh", "-sol", "-hmin", "-hmax", "-hausd"}),
            (Words{"a.mesh", "--metric", "--hmin", "--hmax", "--hausd"}));
}

TEST(TranslateAliases, LeavesOtherWordsAlone) {
  const Words words = {"adapt", "--metric", "-o", "-x", "metric", "--", "-met"};
  EXPECT_EQ(translate_aliases(words), words);
}

TEST(ClosestWord, FindsAMisspeltSubcommand) {
  const Words names = {"adapt", "stat", "verify"};
  EXPECT_EQ(closest_word("adpt", names), "adapt");
  EXPECT_EQ(closest_word("stats", names), "stat");
  EXPECT_EQ(closest_word("wing.meshb", names), "");
}

}  // namespace
}  // namespace weft::tools::arguments_test

#include <gtest/gtest.h>

#include "tools/library/report/run_progress_text.h"

namespace weft::tools::progress_test {
namespace {

using graph::adaptation::RunProgress;

TEST(ProgressText, SaysThatItDoesNotKnow) {
  RunProgress progress;
  progress.subdomains = 128;
  progress.seconds = 1.5;
  EXPECT_EQ(text_of(progress), "interior: 0 of 128 subdomains, time left unknown, 1.50 s");
}

TEST(ProgressText, SaysWhatIsWrongWhereItIsKnown) {
  RunProgress progress;
  progress.subdomains = 128;
  progress.done = 37;
  progress.adapted = 40;
  progress.left = {1234567, 12, 45000, 678};
  progress.seconds = 12.3;
  progress.step_left = 35.4;
  EXPECT_EQ(
      text_of(progress),
      "interior: 37 of 128 subdomains, this step about 36 s more, then shifts, 1,234,567 tets, remaining: "
      "45,678 edges, 12 poor tets in 40 subdomains, 12.3 s");
}

TEST(ProgressText, GivesARangeAfterAShift) {
  RunProgress progress;
  progress.subdomains = 4;
  progress.most_shifts = 8;
  progress.step = 2;
  progress.done = 3;
  progress.at_rest = 1;
  progress.step_left = 4;
  progress.all_left = 9;
  progress.most_left = 200;
  EXPECT_EQ(
      text_of(progress),
      "shift 2 of at most 8: 3 of 4 subdomains (1 at rest), this step about 4 s more, all about 9 s (at "
      "most 3 min), 0.00 s");
}

}  // namespace
}  // namespace weft::tools::progress_test

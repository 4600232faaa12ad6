#include "tools/library/jobs/run_work.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace weft::tools::run_work_test {
namespace {

TEST(SharesOfARun, AscendFromStepToStep) {
  for (const double wanted : {1e4, 1e6, 1e8})
    for (const bool has_fields : {false, true}) {
      const RunWork work(1e6, wanted, has_fields);
      const std::vector<double> shares = {0,
                                          work.at_metric(),
                                          work.at_measures_before(),
                                          work.at_adaptation(0),
                                          work.at_adaptation(0.5),
                                          work.at_adaptation(1),
                                          work.at_fields(),
                                          work.at_writing(),
                                          1};
      EXPECT_TRUE(std::ranges::is_sorted(shares)) << wanted;
    }
}

TEST(SharesOfARun, OfAnUnknownComplexityAreThoseOfAResultAsLargeAsTheInput) {
  const double unknown = RunWork::to_complexity(1.2e6, 0, false).at_adaptation(0);
  EXPECT_EQ(unknown, RunWork::to_complexity(1.2e6, 1e5, false).at_adaptation(0));
  EXPECT_NE(unknown, RunWork::to_complexity(1.2e6, 1e6, false).at_adaptation(0));
}

TEST(SharesOfARun, OfALargeResultAreOfItsAdaptation) {
  const RunWork work(1e4, 1e7, false);
  EXPECT_LT(work.at_adaptation(0), 0.02);
  EXPECT_GT(work.at_adaptation(1), 0.9);
}

TEST(SharesOfARun, OfAResultMuchSmallerThanTheInputAreOfReadingAndMeasuringToo) {
  const RunWork work(1e7, 1e4, false);
  EXPECT_GT(work.at_adaptation(0), 0.2);
}

}  // namespace
}  // namespace weft::tools::run_work_test

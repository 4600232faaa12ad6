#include "meshing/adapt/work.h"

#include <gtest/gtest.h>

namespace weft::meshing::work_test {
namespace {

TEST(PredictedWorkOfAnAdaptation, OfAMeshThatHasItsSizeIsMostlyReconnection) {
  const PredictedWork work = predict_work(1e6, 1e6);
  EXPECT_EQ(work.create, 0);
  EXPECT_GT(work.reconnect, 0.5 * work.sum());
}

TEST(PredictedWorkOfAnAdaptation, OfAMeshThatGrowsIsCreationToo) {
  const PredictedWork work = predict_work(1e5, 1e6);
  EXPECT_GT(work.create, 0.3 * work.sum());
  EXPECT_LT(work.collapse, 0.05 * work.sum());
}

TEST(PredictedWorkOfAnAdaptation, OfAMeshThatIsMadeCoarseIsCollapsing) {
  const PredictedWork work = predict_work(1e6, 1e5);
  EXPECT_EQ(work.create, 0);
  EXPECT_GT(work.collapse, 0.3 * work.sum());
}

TEST(PredictedWorkOfAnAdaptation, HasNoMoreRoundsOnceSplitsAreRare) {
  EXPECT_EQ(work::rounds_after(100, 1e6), 0);
  EXPECT_GT(work::rounds_after(200000, 1e6), work::rounds_after(50000, 1e6));
}

TEST(WorkMeterOfAnAdaptation, ReachesAllWhenNothingIsLeft) {
  WorkMeter meter;
  meter.expect(4);
  EXPECT_DOUBLE_EQ(meter.share(1), 0.25);
  meter.spend(4);
  EXPECT_DOUBLE_EQ(meter.share(0), 1);
}

TEST(WorkMeterOfAnAdaptation, NeverGoesBackWhenMoreIsLeftThanWasExpected) {
  WorkMeter meter;
  meter.expect(2);
  meter.spend(1);
  const double before = meter.share(0);
  meter.expect(100);
  EXPECT_EQ(meter.share(0), before);
}

}  // namespace
}  // namespace weft::meshing::work_test

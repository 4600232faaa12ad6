// Sums of what subdomains tell, and what rank 0 makes of them: counts, the slowest step, and estimates that
// do not guess.
#include "graph/adaptation/progress.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace weft::graph::adaptation::progress_test {
namespace {

constexpr engine::TimePoint kSecond = 1'000'000'000;

SubdomainProgress report(std::uint32_t step, float done = 0, bool rests = false) {
  SubdomainProgress news{.step = step, .rests = rests, .done = done, .predicted_tets = 1000};
  if (step > 0 || done == 1) news.left = {1000, 3, 20, 10};
  return news;
}

/// Tells of subdomains by number, and asks at seconds since the begin.
class Scene {
 public:
  explicit Scene(std::uint32_t subdomains, std::uint32_t most_shifts = 8)
      : estimator_(subdomains, most_shifts, 100 * kSecond), told_(subdomains) {}

  void at_step(std::uint32_t subdomain, std::uint32_t step, float done = 0, bool rests = false) {
    const SubdomainProgress now = report(step, done, rests);
    sums_.replace(told_[subdomain], now);
    told_[subdomain] = now;
    estimator_.hear(sums_);
  }
  RunProgress at(double seconds) {
    return estimator_.at(100 * kSecond + static_cast<engine::TimePoint>(seconds * 1e9));
  }

 private:
  ProgressEstimator estimator_;
  ProgressSums sums_;
  std::vector<std::optional<SubdomainProgress>> told_;
};

TEST(ProgressBoard, HasTheLatestOfAllWhenOneIsNew) {
  ProgressBoard board;
  EXPECT_FALSE(board.take());
  board.post({}, report(0, 0.5));
  board.post({}, report(2));
  board.post(report(0, 0.5), report(1));
  ProgressSums expected;
  expected.replace({}, report(1));
  expected.replace({}, report(2));
  const auto sums = board.take();
  ASSERT_TRUE(sums);
  EXPECT_EQ(sums->steps, expected.steps);
  EXPECT_EQ(sums->left, expected.left);
  EXPECT_FALSE(board.take());
  board.post(report(1), report(1, 1));
  EXPECT_EQ(board.take()->steps[1].done, 1);
}

TEST(ProgressSums, AreOfASubdomainWhereverItHasTold) {
  ProgressSums here, there, expected;
  here.replace({}, report(1, 1));
  there.replace({}, report(2));
  there.replace(report(1, 1), report(3, 0, true));  // has moved
  for (const std::uint32_t step : {2u, 3u}) expected.replace({}, report(step, 0, step == 3));
  here += there;
  EXPECT_EQ(here.steps, expected.steps);
  EXPECT_EQ(here.left, expected.left);
}

TEST(ProgressEstimator, CountsTooFewOfThoseThatMoveUntilBothRanksAreHeard) {
  ProgressSums here, there;
  there.replace({}, report(0, 1));
  there.replace(report(1, 1), report(2));  // has come from here
  ProgressEstimator estimator(2, 8, 0);
  estimator.hear(there);
  const RunProgress early = estimator.at(kSecond);
  EXPECT_EQ(early.step, 0u);
  EXPECT_EQ(early.done, 1u);
  EXPECT_EQ(early.left.tets, 1000u);
  EXPECT_LE(early.share, 1);
  here.replace({}, report(0));
  here.replace(report(0), report(1, 1));
  estimator.hear(here += there);
  const RunProgress late = estimator.at(2 * kSecond);
  EXPECT_EQ(late.step, 0u);
  EXPECT_EQ(late.done, 2u);
  EXPECT_EQ(late.left.tets, 2000u);
}

TEST(ProgressEstimator, NothingIsLessThanNothing) {
  ProgressSums sums;
  sums.replace(report(1, 1, true), report(1));  // has moved, and nobody has heard of it before
  ProgressEstimator estimator(2, 8, 0);
  estimator.hear(sums);
  const RunProgress progress = estimator.at(kSecond);
  EXPECT_EQ(progress.at_rest, 0u);
  EXPECT_EQ(progress.done, 0u);
  EXPECT_EQ(progress.share, 0);
}

TEST(ProgressEstimator, KnowsNothingAtFirst) {
  Scene scene(4);
  const RunProgress progress = scene.at(10);
  EXPECT_EQ(progress.step, 0u);
  EXPECT_EQ(progress.done, 0u);
  EXPECT_EQ(progress.adapted, 0u);
  EXPECT_DOUBLE_EQ(progress.seconds, 10);
  EXPECT_FALSE(progress.step_left);
  EXPECT_FALSE(progress.most_left);
}

TEST(ProgressEstimator, ExtrapolatesTheInteriorAndNothingBeyondIt) {
  Scene scene(4);
  scene.at_step(0, 1);
  EXPECT_FALSE(scene.at(1).step_left) << "too soon";
  const RunProgress progress = scene.at(10);
  EXPECT_EQ(progress.done, 1u);
  EXPECT_EQ(progress.adapted, 1u);
  EXPECT_EQ(progress.left, (meshing::Nonconforming{1000, 3, 20, 10}));
  EXPECT_DOUBLE_EQ(progress.share, 0.25);
  ASSERT_TRUE(progress.step_left);
  EXPECT_NEAR(*progress.step_left, 30, 1e-6);
  EXPECT_FALSE(progress.all_left) << "no shift has been seen";
  EXPECT_FALSE(progress.most_left);
  scene.at_step(1, 0, 0.5);
  EXPECT_NEAR(scene.at(10).share, 0.375, 1e-9) << "the share that one has done of its step counts";
}

TEST(ProgressEstimator, EstimatesAndBoundsTheRestOnceThereWasAShift) {
  Scene scene(2, 5);
  for (std::uint32_t s : {0u, 1u}) scene.at_step(s, 1);
  EXPECT_FALSE(scene.at(20).step_left) << "the first shift has just begun";
  for (std::uint32_t s : {0u, 1u}) scene.at_step(s, 2);
  const RunProgress begun = scene.at(30);  // the first took 10 s
  EXPECT_EQ(begun.step, 2u);
  EXPECT_NEAR(*begun.step_left, 5.5, 1e-6) << "shifts use to get shorter";
  EXPECT_NEAR(*begun.all_left, 5.5 * (1 + 0.55 + 0.55 * 0.55 + 0.55 * 0.55 * 0.55), 1e-6);
  EXPECT_NEAR(*begun.most_left, 10 + 3 * 10, 1e-6) << "whether these do has not been seen";
  scene.at_step(0, 3);
  const RunProgress half = scene.at(34);
  EXPECT_NEAR(*half.step_left, 4, 1e-6) << "by its own pace";
  EXPECT_NEAR(*half.most_left, 4 + 3 * 8, 1e-6);
}

TEST(ProgressEstimator, EstimatesByThePaceOfTheFirstShift) {
  Scene scene(2, 2);
  for (std::uint32_t s : {0u, 1u}) scene.at_step(s, 1);
  scene.at(20);
  scene.at_step(0, 2);
  const RunProgress half = scene.at(24);
  EXPECT_NEAR(*half.step_left, 4, 1e-6);
  EXPECT_NEAR(*half.all_left, 4 + 0.55 * 8, 1e-6);
  EXPECT_NEAR(*half.most_left, 4 + 8, 1e-6);
}

TEST(ProgressEstimator, GoesByHowMuchShorterShiftsHaveBecome) {
  Scene scene(1, 5);
  for (const auto& [step, begin] : {std::pair(1u, 0.0), {2u, 40.0}, {3u, 60.0}, {4u, 70.0}}) {
    scene.at_step(0, step);
    scene.at(begin);
  }
  const RunProgress progress = scene.at(70);  // they took 40, 20 and 10 s
  const double usual = std::cbrt(0.55 * 0.25);
  EXPECT_NEAR(*progress.step_left, 10 * usual, 1e-6);
  EXPECT_NEAR(*progress.all_left, 10 * usual * (1 + usual), 1e-6);
  EXPECT_NEAR(*progress.most_left, 10 + 7.5, 1e-6);
}

TEST(ProgressEstimator, BoundsByTheSlowestDecayThatWasSeen) {
  Scene scene(1, 4);
  for (const auto& [step, begin] : {std::pair(1u, 0.0), {2u, 10.0}, {3u, 19.0}}) {
    scene.at_step(0, step);
    scene.at(begin);
  }
  EXPECT_NEAR(*scene.at(19).most_left, 9 + 9 * 0.9, 1e-6);
}

TEST(ProgressEstimator, ThoseAtRestAreDoneAndHoldNobodyUp) {
  Scene scene(3, 4);
  scene.at_step(0, 1, 1, true);
  scene.at_step(1, 3);
  scene.at_step(2, 4);
  const RunProgress progress = scene.at(5);
  EXPECT_EQ(progress.step, 3u);
  EXPECT_EQ(progress.at_rest, 1u);
  EXPECT_EQ(progress.done, 2u);
}

TEST(ProgressEstimator, OneThatIsWokenDoesNotTurnTheStepBack) {
  Scene scene(2);
  scene.at_step(0, 3), scene.at_step(1, 1, 1, true);
  EXPECT_EQ(scene.at(1).step, 3u);
  scene.at_step(1, 2);
  EXPECT_EQ(scene.at(2).step, 3u);
}

TEST(ProgressEstimator, NoTimeIsLeftBelowZero) {
  Scene scene(1, 2);
  scene.at_step(0, 1), scene.at(1);
  scene.at_step(0, 2), scene.at(2);
  const RunProgress late = scene.at(50);  // nothing heard since
  EXPECT_EQ(*late.step_left, 0);
  EXPECT_EQ(*late.all_left, 0);
  EXPECT_EQ(*late.most_left, 0);
}

}  // namespace
}  // namespace weft::graph::adaptation::progress_test

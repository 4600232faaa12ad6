// What rank 0 makes of the subdomains' news: counts, the slowest step, and estimates that do not guess.
#include "graph/adaptation/progress.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace weft::graph::adaptation::progress_test {
namespace {

constexpr engine::TimePoint kSecond = 1'000'000'000;

/// Sends news of subdomains by number, and asks at seconds since the begin.
class Scene {
 public:
  explicit Scene(std::uint32_t subdomains, std::uint32_t most_shifts = 8)
      : table_(subdomains, most_shifts, 100 * kSecond) {}

  void at_step(std::uint32_t subdomain, std::uint32_t step, float done = 0, bool rests = false) {
    SubdomainProgress news;
    news.subdomain = partition::SubdomainId(subdomain);
    news.number = ++number_;
    news.step = step;
    news.done = done;
    news.rests = rests;
    news.predicted_tets = 1000;
    if (step > 0 || done == 1) news.left = {1000, 3, 20, 10};
    table_.hear({news});
  }
  RunProgress at(double seconds) {
    return table_.at(100 * kSecond + static_cast<engine::TimePoint>(seconds * 1e9));
  }

 private:
  ProgressTable table_;
  std::uint32_t number_ = 0;
};

TEST(ProgressBoard, KeepsTheLatestOfEachSubdomainUntilItIsTaken) {
  ProgressBoard board;
  for (std::uint32_t number : {1u, 2u, 3u})
    board.post({.subdomain = partition::SubdomainId(7), .number = number});
  board.post({.subdomain = partition::SubdomainId(8), .number = 1});
  auto news = board.take();
  ASSERT_EQ(news.size(), 2u);
  EXPECT_EQ(news[0].subdomain.value + news[1].subdomain.value, 15u);
  EXPECT_EQ(news[0].number + news[1].number, 4u);
  EXPECT_TRUE(board.take().empty());
}

TEST(ProgressTable, NewsThatAreOvertakenDoNotCount) {
  ProgressTable table(1, 8, 0);
  table.hear({{.subdomain = partition::SubdomainId(0), .number = 5, .step = 2, .predicted_tets = 1}});
  table.hear({{.subdomain = partition::SubdomainId(0), .number = 4, .step = 1, .predicted_tets = 1}});
  EXPECT_EQ(table.at(kSecond).step, 2u);
}

TEST(ProgressTable, KnowsNothingAtFirst) {
  Scene scene(4);
  const RunProgress progress = scene.at(10);
  EXPECT_EQ(progress.step, 0u);
  EXPECT_EQ(progress.done, 0u);
  EXPECT_EQ(progress.adapted, 0u);
  EXPECT_DOUBLE_EQ(progress.seconds, 10);
  EXPECT_FALSE(progress.step_left);
  EXPECT_FALSE(progress.most_left);
}

TEST(ProgressTable, ExtrapolatesTheInteriorAndNothingBeyondIt) {
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

TEST(ProgressTable, EstimatesAndBoundsTheRestOnceThereWasAShift) {
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

TEST(ProgressTable, EstimatesByThePaceOfTheFirstShift) {
  Scene scene(2, 2);
  for (std::uint32_t s : {0u, 1u}) scene.at_step(s, 1);
  scene.at(20);
  scene.at_step(0, 2);
  const RunProgress half = scene.at(24);
  EXPECT_NEAR(*half.step_left, 4, 1e-6);
  EXPECT_NEAR(*half.all_left, 4 + 0.55 * 8, 1e-6);
  EXPECT_NEAR(*half.most_left, 4 + 8, 1e-6);
}

TEST(ProgressTable, GoesByHowMuchShorterShiftsHaveBecome) {
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

TEST(ProgressTable, BoundsByTheSlowestDecayThatWasSeen) {
  Scene scene(1, 4);
  for (const auto& [step, begin] : {std::pair(1u, 0.0), {2u, 10.0}, {3u, 19.0}}) {
    scene.at_step(0, step);
    scene.at(begin);
  }
  EXPECT_NEAR(*scene.at(19).most_left, 9 + 9 * 0.9, 1e-6);
}

TEST(ProgressTable, ThoseAtRestAreDoneAndHoldNobodyUp) {
  Scene scene(3, 4);
  scene.at_step(0, 1, 1, true);
  scene.at_step(1, 3);
  scene.at_step(2, 4);
  const RunProgress progress = scene.at(5);
  EXPECT_EQ(progress.step, 3u);
  EXPECT_EQ(progress.at_rest, 1u);
  EXPECT_EQ(progress.done, 2u);
}

TEST(ProgressTable, OneThatIsWokenDoesNotTurnTheStepBack) {
  Scene scene(2);
  scene.at_step(0, 3), scene.at_step(1, 1, 1, true);
  EXPECT_EQ(scene.at(1).step, 3u);
  scene.at_step(1, 2);
  EXPECT_EQ(scene.at(2).step, 3u);
}

TEST(ProgressTable, NoTimeIsLeftBelowZero) {
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

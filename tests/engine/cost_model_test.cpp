// Predictions of the cost model: learning curves and objects, outliers, nonsense.
#include "engine/schedule/cost_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>
#include <vector>

namespace weft::engine::cost_model_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// What the model has learnt of some objects.
class Objects {
 public:
  Experiences& operator()(std::uint32_t number) { return known_[number]; }

 private:
  std::map<std::uint32_t, Experiences> known_;
};

/// Measures `count` runs on as many objects, expected to take 1 ms to 1 s, that take `truth(expected)`,
/// scattered a little; of every ten samples, `outliers` take 100 times as long.
template <class Truth>
void measure(CostModel& model, int count, const Truth& truth, int outliers = 0) {
  Objects object;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> magnitude(std::log(1e-3), 0);
  std::normal_distribution<double> scatter(0, 0.1);
  for (int i = 0; i < count; ++i) {
    const double expected = std::exp(magnitude(random));
    const double factor = i % 10 < outliers ? 100 : 1;
    model.measured(0, object(static_cast<std::uint32_t>(i + 1)), expected,
                   factor * truth(expected) * std::exp(scatter(random)));
  }
}

TEST(CostModel, BelievesTheApplicationUntilItHasSamples) {
  CostModel model(1);
  Objects object;
  for (int i = 0; i < 8; ++i) {
    EXPECT_NEAR(model.predict(0, object(1), 0.5), 0.5, 1e-12) << i;
    model.measured(0, object(1), 0.5, 3.0);
  }
  EXPECT_NEAR(model.predict(0, object(2), 0.5), 3.0, 1e-9);
}

TEST(CostModel, FindsAPowerLaw) {
  CostModel model(1);
  Objects object;
  measure(model, 256, [](double expected) { return 7 * std::pow(expected, 1.5); });
  EXPECT_NEAR(model.curve(0).slope, 1.5, 0.03);
  EXPECT_NEAR(model.predict(0, object(9999), 0.1), 7 * std::pow(0.1, 1.5), 0.01);
}

TEST(CostModel, FindsAPowerLawAmongOutliers) {
  for (const double slope : {0.5, 1.0, 2.0}) {
    CostModel model(1);
    Objects object;
    measure(
        model, 256, [&](double expected) { return 3 * std::pow(expected, slope); }, 1);
    EXPECT_NEAR(model.curve(0).slope, slope, 0.05);
    EXPECT_NEAR(model.curve(0).intercept, std::log(3), 0.1);
  }
}

TEST(CostModel, EightSamplesAreEnoughForAFirstGuess) {
  CostModel model(1);
  Objects object;
  measure(model, 8, [](double expected) { return 2 * std::pow(expected, 1.3); });
  EXPECT_NEAR(model.curve(0).slope, 1.3, 0.2);
}

TEST(CostModel, LearnsOnlyAFactorWhenExpectationsHardlyVary) {
  CostModel model(1);
  Objects object;
  for (int i = 0; i < 64; ++i) {
    const double expected = i % 2 == 0 ? 1.0 : 1.02;
    model.measured(0, object(1), expected, i % 2 == 0 ? 4.0 : 5.0);  // would be a slope of 11
  }
  EXPECT_EQ(model.curve(0).slope, 1);
  EXPECT_NEAR(model.predict(0, object(2), 1.0), 4.5, 0.6);
}

TEST(CostModel, LearnsOnlyAFactorFromOneExpectationAndAnOdd) {
  CostModel model(1);
  Objects object;
  for (int i = 0; i < 16; ++i) model.measured(0, object(1), i == 5 ? 3.0 : 1.0, 2.0);
  EXPECT_EQ(model.curve(0).slope, 1);
  EXPECT_NEAR(model.predict(0, object(2), 1.0), 2.0, 1e-9);
}

TEST(CostModel, NeverPredictsLessForMoreWork) {
  CostModel model(1);
  Objects object;
  measure(model, 256, [](double expected) { return 1e-3 / expected; });
  EXPECT_EQ(model.curve(0).slope, 0);
  EXPECT_LE(model.predict(0, object(1), 0.01), model.predict(0, object(1), 0.1));
}

TEST(CostModel, BoundsTheSlope) {
  CostModel model(1);
  Objects object;
  measure(model, 256, [](double expected) { return std::pow(expected, 5); });
  EXPECT_EQ(model.curve(0).slope, 3);
}

TEST(CostModel, PredictsMonotonouslyAndFinitelyWhateverIsExpected) {
  CostModel model(1);
  Objects object;
  measure(model, 512, [](double expected) { return 1e6 * std::pow(expected, 2.5); });
  double last = 0;
  for (double expected = 1e-300; expected < 1e300; expected *= 10) {
    const double predicted = model.predict(0, object(1), expected);
    ASSERT_TRUE(std::isfinite(predicted) && predicted > 0) << expected;
    ASSERT_GE(predicted, last) << expected;
    last = predicted;
  }
  EXPECT_GE(model.predict(0, object(1), kInfinity), last);
}

TEST(CostModel, FollowsAMethodThatChanges) {
  CostModel model(1);
  Objects object;
  measure(model, 256, [](double expected) { return expected; });
  measure(model, 256, [](double expected) { return 10 * expected; });
  EXPECT_NEAR(model.predict(0, object(9999), 0.1), 1.0, 0.1);
}

TEST(CostModel, WithoutExpectationTakesTheMeanOfTheObjectThenOfTheMethod) {
  CostModel model(2);
  Objects object;
  EXPECT_DOUBLE_EQ(model.predict(0, object(1), 0), 1e-4);
  model.measured(0, object(1), 0, 2.0);
  model.measured(0, object(1), 0, 4.0);
  model.measured(0, object(2), 0, 12.0);
  EXPECT_DOUBLE_EQ(model.predict(0, object(1), 0), 3.0);
  EXPECT_DOUBLE_EQ(model.predict(0, object(2), 0), 12.0);
  EXPECT_DOUBLE_EQ(model.predict(0, object(3), 0), 6.0);
  EXPECT_DOUBLE_EQ(model.predict(1, object(1), 0), 1e-4) << "another method";
}

TEST(CostModel, WithoutExpectationFollowsAnObjectThatGrows) {
  CostModel model(1);
  Objects object;
  for (int i = 0; i < 50; ++i) model.measured(0, object(1), 0, 1.0);
  for (int i = 0; i < 20; ++i) model.measured(0, object(1), 0, 5.0);
  EXPECT_NEAR(model.predict(0, object(1), 0), 5.0, 0.1);
}

TEST(CostModel, LearnsHowMuchAnObjectIsOff) {
  CostModel model(1);
  Objects object;
  measure(model, 256, [](double expected) { return expected; });
  for (int i = 0; i < 30; ++i) model.measured(0, object(1), 0.1, 0.3);
  EXPECT_NEAR(model.predict(0, object(1), 0.1), 0.3, 0.02);
  EXPECT_NEAR(model.predict(0, object(1), 0.2), 0.6, 0.04) << "as much for other expectations";
  EXPECT_NEAR(model.predict(0, object(9999), 0.1), 0.1, 0.01) << "others are as before";
}

TEST(CostModel, BelievesAnObjectToBeOffByAFactorOfEightAtMost) {
  CostModel model(1);
  Objects object;
  measure(model, 256, [](double expected) { return expected; });
  for (int i = 0; i < 60; ++i) model.measured(0, object(1), 0.1, 1e5);
  EXPECT_NEAR(model.predict(0, object(1), 0.1), 0.8, 0.05);
  model.measured(0, object(1), 0.1, 0.1);
  EXPECT_LT(model.predict(0, object(1), 0.1), 0.6) << "and recovers soon";
}

TEST(CostModel, OfAnUnknownObjectOnlyTheMethodIsKnown) {
  CostModel model(1);
  Objects object;
  model.measured(0, object(1), 0, 2.0);
  model.measured(0, object(2), 0, 4.0);
  object(1).clear();
  EXPECT_DOUBLE_EQ(model.predict(0, object(1), 0), 3.0) << "the method's";
  EXPECT_DOUBLE_EQ(model.predict(0, object(2), 0), 4.0);
}

TEST(CostModel, MethodsLearnApart) {
  CostModel model(2);
  Objects object;
  measure(model, 64, [](double expected) { return 5 * expected; });
  EXPECT_NEAR(model.predict(1, object(1), 0.3), 0.3, 1e-12);
}

TEST(CostModel, NonsenseDoesNoHarm) {
  const std::vector<double> nonsense = {0.0,   -1.0, kNan,   kInfinity, -kInfinity,
                                        1e300, -0.0, 1e-320, 1e-300,    std::numeric_limits<double>::max()};
  CostModel model(1);
  Objects object;
  for (int round = 0; round < 40; ++round) {
    for (const double expected : nonsense) {
      for (const double seconds : nonsense) model.measured(0, object(1), expected, seconds);
    }
  }
  for (const double expected : nonsense) {
    for (const std::uint32_t number : {1u, 2u}) {
      const double predicted = model.predict(0, object(number), expected);
      EXPECT_TRUE(std::isfinite(predicted) && predicted > 0) << expected;
    }
  }
}

TEST(CostModel, SaysWhichMethodsItHas) {
  CostModel model(2);
  Objects object;
  EXPECT_THROW(model.predict(2, object(1), 1), std::out_of_range);
  EXPECT_THROW(model.measured(2, object(1), 1, 1), std::out_of_range);
}

}  // namespace
}  // namespace weft::engine::cost_model_test

// How many subdomains a run begins in.
#include "graph/adaptation/phase_plan.h"

#include <gtest/gtest.h>

namespace weft::graph::adaptation::phase_plan_test {
namespace {

constexpr double kNear = 0.85, kFar = 0.4;

std::uint32_t parts(std::uint64_t tets, double complexity, double quality, std::uint32_t subdomains,
                    partition::Partitioner partitioner = {}) {
  partition::InputMeasures input;
  input.tets = tets, input.complexity = complexity, input.mean_quality = quality;
  PlanOptions options;
  options.subdomains = subdomains, options.partitioner = partitioner;
  return parts_at_first(input, options);
}

TEST(PartsAtFirst, AreAllWhereTheInputIsNearItsMetricAndHasTetsForEach) {
  EXPECT_EQ(parts(100'000, 200'000, kNear, 128), 128u);
}

TEST(PartsAtFirst, AreSoManyThatSeedsAreSmallButHaveTetsOfTheInput) {
  EXPECT_EQ(parts(85'000, 200'000, kNear, 1024), 25u) << "250,000 tets are divided, 10,000 of each";
  EXPECT_EQ(parts(2'000, 200'000, kNear, 1024), 20u) << "a hundred of the input's";
  EXPECT_EQ(parts(6, 76'800, kNear, 128), 1u);
  EXPECT_EQ(parts(85'000, 5'000'000, kNear, 5120), 78u);
}

TEST(PartsAtFirst, AreFewFarFromTheMetric) {
  EXPECT_EQ(parts(85'000, 200'000, kFar, 1024), 25u) << "four times 2,000 tets are less than 10,000";
  EXPECT_EQ(parts(85'000, 5'000'000, kFar, 5120), 20u);
  EXPECT_EQ(parts(500, 500'000, kFar, 128), 1u);
}

TEST(PartsAtFirst, AreFewWhereOneTetWouldBecomeTooMuchForASubdomain) {
  partition::InputMeasures input{100'000, 200'000, kNear, 1.9 / 128};
  PlanOptions options;
  options.subdomains = 128;
  EXPECT_EQ(parts_at_first(input, options), 128u);
  input.largest_share = 2.1 / 128;
  EXPECT_LT(parts_at_first(input, options), 64u);
  options.subdomains = 64;
  EXPECT_EQ(parts_at_first(input, options), 64u);
}

TEST(PartsAtFirst, AreOneOrAllForSlabs) {
  const partition::Partitioner slabs{.kind = partition::Partitioner::Kind::pqr};
  EXPECT_EQ(parts(500, 50'000, kNear, 64, slabs), 1u);
  EXPECT_EQ(parts(85'000, 200'000, kNear, 1024, slabs), 1024u);
}

}  // namespace
}  // namespace weft::graph::adaptation::phase_plan_test

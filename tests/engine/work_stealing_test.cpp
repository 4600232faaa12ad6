// What a rank gives to one that asks, or that has less.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "engine/balance/balancer.h"

namespace weft::engine::work_stealing_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr Rank kMe{0}, kOther{1};

/// A rank with one worker, busy, and objects that wait; notes what moves and what is told.
class BusyRank final : public BalanceActions {
 public:
  BusyRank(std::vector<double> seconds, std::optional<double> move_seconds) : move_seconds_(move_seconds) {
    for (std::uint32_t i = 0; i < seconds.size(); ++i) ready_.push_back({ObjectId{kMe, i + 1}, seconds[i]});
  }

  Rank rank() const override { return kMe; }
  int ranks() const override { return 2; }
  Load load() const override {
    Load load{1, 1, ready_.size(), 0, 0};
    for (const ReadyObject& object : ready_) load.queued_seconds += object.seconds;
    return load;
  }
  std::vector<ReadyObject> ready_objects() const override { return ready_; }
  int ties(ObjectId id, Rank) const override {
    return id.number <= ties_of.size() ? ties_of[id.number - 1] : 0;
  }
  std::optional<double> move_seconds() const override { return move_seconds_; }
  double load_of(Rank) const override { return 0; }
  void move(ObjectId id, Rank to) override {
    EXPECT_EQ(to, kOther);
    moved.push_back(id.number);
  }
  void tell(Rank, const BalanceMessage& message) override { told.push_back(message.kind); }
  void wake_when_ready(bool) override {}
  void done(std::size_t number) { ready_.erase(ready_.begin(), ready_.begin() + static_cast<long>(number)); }
  void more(double seconds) { ready_.push_back({ObjectId{kMe, 100}, seconds}); }

  std::vector<int> ties_of;  ///< by the objects' numbers from 1 on
  std::vector<std::uint32_t> moved, told;

 private:
  std::vector<ReadyObject> ready_;
  std::optional<double> move_seconds_;
};

/// What `rank` gives to another that has nothing to do.
std::vector<std::uint32_t> given_by(BusyRank rank) {
  constexpr BalanceMessage kAsk{0, 0};
  work_stealing()(kMe, 2)->told(kOther, kAsk, rank);
  return rank.moved;
}

TEST(WorkStealing, GivesHalfOfTheWorkInTheLargestObjects) {
  EXPECT_THAT(given_by({{1, 1, 4, 1, 1}, 0.0}), ElementsAre(3));
  EXPECT_THAT(given_by({{1, 1, 1, 1, 1, 1}, 0.0}), ElementsAre(6, 5, 4));
}

TEST(WorkStealing, WhatIsNotWorthItsWayStays) {
  EXPECT_THAT(given_by({{2, 0.1, 0.1, 2, 0.1}, 0.1}), ElementsAre(4));
  EXPECT_THAT(given_by({{0.1, 0.1, 0.1}, 0.1}), IsEmpty());
}

TEST(WorkStealing, GivesFirstWhatLeavesFewestPartnersBehind) {
  BusyRank rank({1, 1, 4, 1, 1}, 0.0);
  rank.ties_of = {0, 2, -3, -1, 0};
  EXPECT_THAT(given_by(rank), ElementsAre(2, 5, 1, 4)) << "the large one would be more than half";
}

TEST(WorkStealing, PartnersThatStayBehindCountAsMoves) {
  BusyRank rank({1, 1, 1, 1}, 0.1);  // worth it from .4 s on
  rank.ties_of = {-1, -7, -8, -7};
  EXPECT_THAT(given_by(rank), ElementsAre(1));
}

/// The kinds of messages, in the order of WorkStealing::Kind.
enum : std::uint32_t { kAsk, kGiven, kLater, kOffer };

TEST(WorkStealing, WhoAskedInVainIsToldOfWorkAndNotSentAny) {
  BusyRank rank({}, 0.0);
  const auto policy = work_stealing()(kMe, 2);
  policy->told(kOther, {kAsk, 0}, rank);
  EXPECT_THAT(rank.told, ElementsAre(kLater));
  policy->step(rank, 1);
  EXPECT_THAT(rank.told, ElementsAre(kLater));
  rank.more(1);
  policy->step(rank, 2);
  policy->step(rank, 3);
  EXPECT_THAT(rank.told, ElementsAre(kLater, kOffer)) << "once";
  EXPECT_THAT(rank.moved, IsEmpty()) << "it may have found work elsewhere";
  policy->told(kOther, {kAsk, 0}, rank);
  EXPECT_THAT(rank.moved, ElementsAre(100));
}

/// What is not worth its way is not offered either, and looked at now and then only.
TEST(WorkStealing, OffersNothingThatItWouldNotGive) {
  BusyRank rank({1}, 0.1);
  rank.ties_of = {-8};
  const auto policy = work_stealing()(kMe, 2);
  policy->told(kOther, {kAsk, 0}, rank);
  policy->step(rank, 1);
  EXPECT_THAT(rank.told, ElementsAre(kLater));
  EXPECT_TRUE(policy->next_step().has_value());
  rank.ties_of = {0};
  policy->step(rank, 2);
  EXPECT_THAT(rank.told, ElementsAre(kLater)) << "it has just looked";
  policy->step(rank, *policy->next_step());
  EXPECT_THAT(rank.told, ElementsAre(kLater, kOffer));
  EXPECT_FALSE(policy->next_step().has_value());
  policy->told(kOther, {kAsk, 0}, rank);
  rank.done(1);
  policy->step(rank, 1'000'000'000);
  EXPECT_FALSE(policy->next_step().has_value()) << "an idle rank need not be woken";
}

TEST(WorkStealing, OneGoesFirstToShowWhatMovingTakes) {
  EXPECT_THAT(given_by({std::vector<double>(60, 0.001), std::nullopt}), ElementsAre(60));
}

TEST(Diffusion, WhatIsNotWorthItsWayStays) {
  const auto moved_by = [](BusyRank rank) {
    diffusion()(kMe, 2)->step(rank, 0);
    return rank.moved;
  };
  EXPECT_THAT(moved_by({{1, 1, 1, 1}, 0.0}), ElementsAre(4, 3));
  EXPECT_THAT(moved_by({{1, 1, 1, 1}, 0.3}), IsEmpty());
  EXPECT_THAT(moved_by({{1, 1, 1, 1}, std::nullopt}), ElementsAre(4)) << "the first shows what moving takes";
}

/// A rank that does nothing but ask, and whom all others answer that they have nothing.
class IdleRank final : public BalanceActions {
 public:
  Rank rank() const override { return kMe; }
  int ranks() const override { return 64; }
  Load load() const override { return now; }
  std::vector<ReadyObject> ready_objects() const override { return {}; }
  int ties(ObjectId, Rank) const override { return 0; }
  std::optional<double> move_seconds() const override { return std::nullopt; }
  double load_of(Rank rank) const override { return rank == loaded ? 1 : 0; }
  void move(ObjectId, Rank) override {}
  void tell(Rank to, const BalanceMessage&) override {
    ++asked;
    last = to;
  }
  void wake_when_ready(bool) override {}

  /// Steps until it asks no more; how many it has asked.
  int asks_in(Balancer& policy) {
    const int before = asked;
    policy.step(*this, 0);
    for (int seen = before; asked > seen;) {
      seen = asked;
      policy.told(last, {2, 0}, *this);
    }
    return asked - before;
  }

  Load now{1, 0, 0, 0, 0};
  int asked = 0;
  Rank last, loaded;
};

TEST(WorkStealing, AsksNearRanksBeforeTheMostLoadedOfAll) {
  IdleRank rank;
  rank.loaded = Rank(2);
  const auto policy = work_stealing()(kMe, rank.ranks());
  policy->step(rank, 0);
  EXPECT_EQ(rank.last, Rank(2));
  rank.loaded = Rank(40);
  policy->told(rank.last, {kLater, 0}, rank);
  EXPECT_EQ(rank.last, Rank(40));
}

TEST(WorkStealing, AnOfferThatComesWhileItAsksOrWorksIsRemembered) {
  IdleRank rank;
  const auto policy = work_stealing()(kMe, rank.ranks());
  policy->step(rank, 0);
  policy->told(Rank(33), {kOffer, 0}, rank);
  EXPECT_EQ(rank.asked, 1);
  policy->told(rank.last, {kLater, 0}, rank);
  EXPECT_EQ(rank.last, Rank(33));
  for (int seen = 0; seen != rank.asked;) {  // until all have been asked
    seen = rank.asked;
    policy->told(rank.last, {kLater, 0}, rank);
  }
  rank.now.busy = 1;
  policy->told(Rank(34), {kOffer, 0}, rank);
  const int before = rank.asked;
  policy->step(rank, 1);
  EXPECT_EQ(rank.asked, before);
  rank.now.busy = 0;
  policy->step(rank, 2);
  EXPECT_EQ(rank.last, Rank(34));
}

TEST(WorkStealing, WhoIsIdleButForMessagesAsksAgainOnlyAfterWork) {
  IdleRank rank;
  const auto policy = work_stealing()(kMe, rank.ranks());
  const int asked = rank.asks_in(*policy);
  EXPECT_GE(asked, 6) << "all neighbours on the hypercube at least";
  EXPECT_LT(asked, 64);
  for (int message = 0; message < 100; ++message) {
    ++rank.now.handled;
    EXPECT_EQ(rank.asks_in(*policy), 0);
  }
  rank.now.queued_seconds = 1;
  rank.now.ready = 1;
  EXPECT_EQ(rank.asks_in(*policy), 0);
  rank.now = {1, 0, 0, 0, rank.now.handled + 1};
  EXPECT_EQ(rank.asks_in(*policy), asked);
}

}  // namespace
}  // namespace weft::engine::work_stealing_test

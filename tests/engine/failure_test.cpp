// Whatever goes wrong on one rank ends the run on all, with one message that says what it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <optional>
#include <thread>

#include "engine/network/exchange.h"
#include "engine/network/loopback_transport.h"
#include "engine/objects/directory.h"
#include "engine/objects/message.h"
#include "engine/run/runtime.h"
#include "tests/support/ranks.h"

namespace weft::engine::failure_test {
namespace {

using ::testing::HasSubstr;
using weft::testing::on_ranks;

/// Fails in all the ways in which an object can.
struct Bomb {
  std::int64_t value = 0;
  bool travels_badly = false;
  bool asks_again = false;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(value);
    if (Archive::kPacks && travels_badly) archive(value);
  }
  void explode(Context&, int) { throw std::runtime_error("the powder was dry"); }
  void explode_oddly(Context&) { throw 5; }
  void shorten_fuse(Context&) { travels_badly = true; }
  void tick(Context&) { ++value; }
  void wait_for(Context& context, ObjectId other) { context.expect<&Bomb::meet>(7, {other}); }
  void call(Context& context, ObjectId other) { context.signal<&Bomb::meet>(MobilePtr<Bomb>{other}, 7); }
  void wait_and_ask_again(Context& context, ObjectId other) {
    asks_again = true;
    wait_for(context, other);
  }
  void meet(Context& context, std::uint64_t, std::vector<Arrival<Nothing>> arrivals) {
    if (asks_again) context.invoke<&Bomb::call>(MobilePtr<Bomb>{arrivals.front().from}, context.self());
  }
  void last_until_stopped(Context& context) {
    while (!context.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
};

Registry bombs() {
  Registry registry;
  registry.type<Bomb>("Bomb")
      .method<&Bomb::explode>("explode")
      .method<&Bomb::explode_oddly>("explode_oddly")
      .method<&Bomb::shorten_fuse>("shorten_fuse")
      .method<&Bomb::tick>("tick")
      .method<&Bomb::wait_for>("wait_for")
      .method<&Bomb::wait_and_ask_again>("wait_and_ask_again")
      .method<&Bomb::call>("call")
      .method<&Bomb::last_until_stopped>("last_until_stopped")
      .event<&Bomb::meet>("meet");
  return registry;
}

const auto kBomb = [](int rank, std::uint32_t number = 1) { return MobilePtr<Bomb>{{Rank(rank), number}}; };

/// The message with which `act`, performed on every rank in a run in which each has a bomb, must fail there.
/// One rank alone reports it.
void expect_failure(int ranks, const std::function<void(Context&)>& act, const std::string& message) {
  std::atomic<int> reporters{0};
  on_ranks(ranks, [&](Transport& transport) {
    const Registry registry = bombs();
    Runtime runtime(transport, registry,
                    {.threads = 2, .balancer = no_balancing(), .on_failure = [&](const std::string& what) {
                       EXPECT_THAT(what, HasSubstr(message));
                       ++reporters;
                     }});
    runtime.run([](Context& context) { context.create<Bomb>(); });
    std::optional<std::string> failure;
    try {
      runtime.run(act);
    } catch (const RunFailure& caught) {
      failure = caught.what();
      EXPECT_EQ(caught.reported_here(), transport.rank() == Rank(0));
      EXPECT_FALSE(caught.network_broken());
    }
    ASSERT_TRUE(failure) << "no failure on rank " << transport.rank().value;
    EXPECT_THAT(*failure, HasSubstr(message));
    EXPECT_THROW(runtime.run(), std::logic_error) << "a failed runtime ran again";
  });
  if (!weft::testing::is_distributed()) {
    EXPECT_EQ(reporters, 1);
  }
}

class FailureOnRanks : public weft::testing::OnRanks {
 protected:
  int last() const { return GetParam() - 1; }
  std::string rank_text() const { return std::to_string(last()); }
};
INSTANTIATE_TEST_SUITE_P(Ranks, FailureOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

/// What the run that `act` makes fails with.
template <class Act>
std::string what_of(const Act& act) {
  try {
    act();
  } catch (const RunFailure& failure) {
    return failure.what();
  }
  return "no failure";
}

TEST_P(FailureOnRanks, AHandlerThatThrowsIsNamedWithItsObjectAndRank) {
  const std::string r = rank_text();
  expect_failure(
      GetParam(), [&](Context& context) { context.invoke<&Bomb::explode>(kBomb(last()), 3); },
      "Bomb::explode of object " + r + ".1 (Bomb) on rank " + r + ": the powder was dry");
}

TEST_P(FailureOnRanks, AnExceptionOfAnyTypeFailsTheRun) {
  expect_failure(
      GetParam(), [&](Context& context) { context.invoke<&Bomb::explode_oddly>(kBomb(last())); },
      "an exception of unknown type");
}

TEST_P(FailureOnRanks, LongHandlersAreToldToStop) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        context.invoke<&Bomb::last_until_stopped>(kBomb(context.rank().value));
        if (context.rank() != Rank(last())) return;
        context.invoke<&Bomb::explode>(context.create<Bomb>(), 0);
      },
      "the powder was dry");
}

TEST_P(FailureOnRanks, ARootFunctionThatThrowsIsNamed) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() == Rank(last())) throw std::runtime_error("no input");
      },
      "the root function on rank " + rank_text() + ": no input");
}

TEST_P(FailureOnRanks, AnObjectThatCannotBeUnpackedIsNamed) {
  if (GetParam() == 1) GTEST_SKIP() << "for several ranks";
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() != Rank(0)) return;
        context.invoke<&Bomb::shorten_fuse>(kBomb(0));
        context.migrate(kBomb(0), Rank(1));
        context.invoke<&Bomb::tick>(kBomb(0));
      },
      "Bomb::tick of object 0.1 (Bomb) on rank 1: the message cannot be read: there is more in the message "
      "than was read");
}

TEST_P(FailureOnRanks, ARankWithAnotherProgramIsNamedBeforeAnythingIsHandled) {
  if (GetParam() == 1) GTEST_SKIP() << "for several ranks";
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry = bombs();
    if (transport.rank() == Rank(last())) {
      registry = Registry();
      registry.type<Bomb>("Bomb").method<&Bomb::explode>("explode");
    }
    Runtime runtime(transport, registry, {.on_failure = {}});
    try {
      runtime.run();
      ADD_FAILURE() << "the run ended";
    } catch (const RunFailure& failure) {
      EXPECT_THAT(failure.what(), HasSubstr("runs another program"));
      EXPECT_FALSE(failure.network_broken());
    }
  });
}

/// Passes everything on until it is told to fail.
class FailingTransport final : public Transport {
 public:
  FailingTransport(Transport& below, std::function<void()> fail) : below_(below), fail_(std::move(fail)) {}

  Rank rank() const override { return below_.rank(); }
  int size() const override { return below_.size(); }
  void send(Rank to, Packet packet) override { below_.send(to, std::move(packet)); }
  std::size_t unsent(Rank to) const override { return below_.unsent(to); }
  void wait(std::chrono::nanoseconds at_most) override { below_.wait(at_most); }
  void wake() noexcept override { below_.wake(); }
  std::optional<LostPeer> lost_peer() override { return below_.lost_peer(); }
  void leave(const std::string& why) noexcept override { below_.leave(why); }
  void close() override { below_.close(); }
  void abandon() noexcept override { below_.abandon(); }
  std::uint64_t next_phase() override { return below_.next_phase(); }
  std::uint64_t first_phase() override { return below_.first_phase(); }
  void end_phase() override { below_.end_phase(); }
  void keep(KeptPacket packet) override { below_.keep(std::move(packet)); }
  std::vector<KeptPacket> take_kept() override { return below_.take_kept(); }
  bool poll(const Receive& receive) override {
    if (failing) fail_();
    return below_.poll(receive);
  }

  std::atomic<bool> failing = false;

 private:
  Transport& below_;
  std::function<void()> fail_;
};

/// What rank 1 of 2 throws whose network fails in the midst of a run, and rank 0.
std::array<std::string, 2> failures_when_polling_fails(const std::function<void()>& fail) {
  std::array<std::string, 2> failures;
  on_ranks(2, [&](Transport& transport) {
    FailingTransport failing(transport, fail);
    const Registry registry = bombs();
    Runtime runtime(failing, registry, {.grace = std::chrono::milliseconds(300), .on_failure = {}});
    try {
      runtime.run([&](Context& context) {
        context.invoke<&Bomb::last_until_stopped>(context.create<Bomb>());
        failing.failing = context.rank() == Rank(1);
      });
    } catch (const RunFailure& failure) {
      EXPECT_TRUE(failure.network_broken() || transport.rank() == Rank(0));
      failures[transport.rank().index()] = failure.what();
    }
  });
  return failures;
}

TEST(Failure, ANetworkThatFailsEndsTheRunOnAllRanks) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  const auto failures = failures_when_polling_fails([] { throw TransportError("the cable is cut"); });
  EXPECT_EQ(failures[1], "the network fails on rank 1: the cable is cut");
  EXPECT_EQ(failures[0], failures[1]);
}

TEST(Failure, ARankThatNeverHearsWhatTheFailureWasGivesUpAfterTheGrace) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  const auto failures =
      failures_when_polling_fails([] { throw std::runtime_error("no message gets through"); });
  EXPECT_EQ(failures[1], "the communication of rank 1: no message gets through");
}

TEST(Failure, ARankThatLeavesIsNotWaitedForInTheNextRun) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  on_ranks(3, [](Transport& transport) {
    const Registry registry = bombs();
    Runtime runtime(transport, registry, {.on_failure = {}});
    runtime.run();
    if (transport.rank() == Rank(2)) return transport.leave("has had enough");
    try {
      runtime.run();
      ADD_FAILURE() << "the run ended without rank 2";
    } catch (const RunFailure& failure) {
      EXPECT_STREQ(failure.what(), "rank 2 has had enough");
      EXPECT_FALSE(failure.network_broken());
    }
  });
}

/// Rank 1's failure in a run in which rank 0, of the same program, sends it what no engine sends.
std::string failure_by(const std::function<void(Exchange&)>& send) {
  LoopbackNetwork network(2);
  const Registry registry = bombs();
  std::string what;
  std::thread other([&] {
    Runtime runtime(network.transport(Rank(1)), registry,
                    {.grace = std::chrono::milliseconds(100), .on_failure = {}});
    try {
      runtime.run();
    } catch (const RunFailure& failure) {
      what = failure.what();
    }
  });
  Exchange exchange(network.transport(Rank(0)), {}, registry.fingerprint());
  exchange.begin_phase();
  send(exchange);
  exchange.progress([](Rank, FrameKind, Payload, std::size_t) {});
  other.join();
  return what;
}

TEST(Failure, RanksAndBytesThatCannotBeAreRefusedWhenTheyComeOverTheNetwork) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  const auto message = [](ObjectId target, ObjectId sender, Rank origin) {
    return [=](Exchange& exchange) {
      Envelope envelope;
      envelope.target = target, envelope.sender = sender, envelope.origin = origin;
      const auto* first = reinterpret_cast<const std::byte*>(&envelope);
      exchange.post(Rank(1), FrameKind::task, {{first, first + sizeof envelope}, {}});
    };
  };
  const ObjectId good{Rank(0), 1};
  for (const Rank bad : {Rank(2), Rank()})
    EXPECT_THAT(failure_by(message(good, good, bad)), HasSubstr("names a rank that does not exist"));
  EXPECT_THAT(failure_by(message({}, good, Rank(0))), HasSubstr("names a rank that does not exist"));
  EXPECT_THAT(failure_by(message(good, {}, Rank(0))), HasSubstr("names a rank that does not exist"));
  EXPECT_THAT(failure_by([&](Exchange& exchange) {
                Packer packer;
                Location nowhere{Rank(2), 1};
                packer(good, nowhere);
                exchange.post(Rank(1), FrameKind::location, packer.take());
              }),
              HasSubstr("there is no rank 2"));
  EXPECT_THAT(failure_by([](Exchange& exchange) { exchange.consumed(Rank(1), std::size_t{1} << 40); }),
              HasSubstr("confirms more than was sent"));
}

/// Exits with 7 when it is told so by an exception.
void start_too_many_threads() {
  const rlimit few{rlim_t{3} << 30, rlim_t{3} << 30};  // of address space: 8 MB a stack
  setrlimit(RLIMIT_AS, &few);
  LoopbackNetwork network(1);
  const Registry registry = bombs();
  try {
    Runtime(network.transport(Rank(0)), registry, {.threads = 5000});
  } catch (const std::exception&) {
    std::_Exit(7);
  }
  std::_Exit(8);
}

TEST(Failure, WithoutThreadsThereIsAnExceptionAndNoEnd) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer needs the address space that is limited here";
#endif
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(start_too_many_threads(), ::testing::ExitedWithCode(7), "");
}

TEST_P(FailureOnRanks, AMessageToADestroyedObjectFailsTheRun) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() != Rank(last())) return;
        context.destroy(kBomb(0));
        context.invoke<&Bomb::tick>(kBomb(0));
      },
      "0.1");
}

TEST_P(FailureOnRanks, AStalledRunSaysWhoWaitsForWhom) {
  const std::string r = rank_text();
  expect_failure(
      GetParam(),
      [&](Context& context) {
        context.create<Bomb>();
        if (context.rank() != Rank(0)) return;
        context.invoke<&Bomb::wait_for>(kBomb(0), kBomb(last(), 2).id);
      },
      "the run has stalled: no handler runs and no message is under way, but\n"
      "  object 0.1 (Bomb, rank 0) waits in Bomb::meet in round 7 for " +
          r + ".2 (");
}

TEST_P(FailureOnRanks, ASignalThatNobodyExpectsIsAStall) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() == Rank(0)) context.invoke<&Bomb::call>(kBomb(0), kBomb(last()).id);
      },
      "(Bomb, rank " + rank_text() + ") never expects Bomb::meet in round 7, signalled by 0.1");
}

TEST_P(FailureOnRanks, ASecondSignalForAnEventThatHasFiredIsAStall) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() != Rank(0)) return;
        context.invoke<&Bomb::wait_and_ask_again>(kBomb(0), kBomb(last()).id);
        context.invoke<&Bomb::call>(kBomb(last()), kBomb(0).id);
      },
      "(Bomb, rank 0) never expects Bomb::meet in round 7, signalled by " + rank_text() + ".1");
}

TEST_P(FailureOnRanks, ASecondSignalForAnEventThatHasNotFiredFailsTheRun) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() != Rank(0)) return;
        for (int time = 0; time < 2; ++time) context.invoke<&Bomb::call>(kBomb(last()), kBomb(0).id);
      },
      "(Bomb) on rank 0: object " + rank_text() + ".1 signals round 7 twice");
}

TEST_P(FailureOnRanks, ASignalFromAStrangerFailsTheRun) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() != Rank(0)) return;
        const auto stranger = context.create<Bomb>();
        context.invoke<&Bomb::wait_for>(kBomb(last()), kBomb(last()).id);
        context.invoke<&Bomb::call>(stranger, kBomb(last()).id);
      },
      "object 0.2");
}

TEST_P(FailureOnRanks, MessagesToAnObjectThatIsNeverCreatedAreAStall) {
  expect_failure(
      GetParam(),
      [&](Context& context) {
        if (context.rank() == Rank(0)) context.invoke<&Bomb::tick>(kBomb(last(), 99));
      },
      "1 messages wait on rank " + rank_text() + " for object " + rank_text() +
          ".99, which was never created");
}

TEST_P(FailureOnRanks, RequestStopEndsTheRunOnAllRanks) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = bombs();
    Runtime runtime(transport, registry);
    std::thread stopper;
    try {
      runtime.run([&](Context& context) {
        context.invoke<&Bomb::last_until_stopped>(context.create<Bomb>());
        if (context.rank() == Rank(last())) stopper = std::thread([&] { runtime.request_stop("enough"); });
      });
      ADD_FAILURE() << "the run did not stop";
    } catch (const RunFailure& failure) {
      EXPECT_STREQ(failure.what(), "enough");
    }
    if (stopper.joinable()) stopper.join();
  });
}

/// Who has had all that comes to it has left a run in which another fails later, and hears of it in its next.
TEST_P(FailureOnRanks, WhoHasLeftARunHearsInTheNextThatItFailed) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = bombs();
    Runtime runtime(transport, registry, {.on_failure = [](const std::string&) {}});
    const auto fail_late = [&] {
      runtime.run_until([] { return true; },
                        [&](Context& context) {
                          if (context.rank() != Rank(last())) return;
                          std::this_thread::sleep_for(std::chrono::milliseconds(50));
                          throw std::runtime_error("no input");
                        });
      runtime.run_until([] { return false; }, {});
    };
    EXPECT_THAT(what_of(fail_late), HasSubstr("no input"));
  });
}

/// Who fails in a run that others have not come to lets them end the one that they are in.
TEST_P(FailureOnRanks, WhoIsAheadFailsNoRunThatOthersAreIn) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = bombs();
    Runtime runtime(transport, registry, {.on_failure = [](const std::string&) {}});
    const bool is_ahead = runtime.rank() == Rank(last());
    runtime.run_until([] { return true; },
                      [&](Context&) {
                        if (!is_ahead) std::this_thread::sleep_for(std::chrono::milliseconds(50));
                      });
    const auto fail_ahead = [&] {
      runtime.run_until([] { return false; },
                        [&](Context&) {
                          if (is_ahead) throw std::runtime_error("no input");
                        });
    };
    EXPECT_THAT(what_of(fail_ahead), HasSubstr("no input"));
  });
}

/// A runtime on the transport of one that has failed hears what is sent to it, and nothing else.
void expect_in_step(Transport& transport) {
  const Registry registry = bombs();
  Runtime runtime(transport, registry, {.balancer = no_balancing(), .on_failure = {}});
  runtime.run_until([] { return true; }, [](Context& context) { context.create<Bomb>(); });
  std::int64_t ticks = 0;
  const auto time_of_end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  runtime.run_until(
      [&] {
        runtime.visit<Bomb>([&](MobilePtr<Bomb>, Bomb& bomb) { ticks = bomb.value; });
        return ticks == 1 || std::chrono::steady_clock::now() > time_of_end;
      },
      [](Context& context) {
        context.invoke<&Bomb::tick>(kBomb((context.rank().value + 1) % context.ranks()));
      });
  EXPECT_EQ(ticks, 1) << "rank " << transport.rank().value << " is not where the others are";
}

/// How a runtime fails in the runs that `act` makes; the next one on the same transport works.
template <class Act>
std::string failure_on(Transport& transport, const Act& act) {
  std::string what = "no failure";
  {
    const Registry registry = bombs();
    Runtime runtime(transport, registry,
                    {.grace = std::chrono::seconds(5), .on_failure = [](const std::string&) {}});
    try {
      act(runtime);
    } catch (const RunFailure& failure) {
      what = failure.what();
      EXPECT_FALSE(failure.network_broken());
    }
  }
  expect_in_step(transport);
  return what;
}

TEST_P(FailureOnRanks, WhoIsSeveralRunsAheadOfAFailureIsInStepAfterIt) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const std::string what = failure_on(transport, [&](Runtime& runtime) {
      const auto fail_late = [&](Context& context) {
        if (context.rank() != Rank(last())) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        throw std::runtime_error("no input");
      };
      runtime.run_until([] { return true; }, fail_late);
      for (int run = 0; run < 3; ++run) runtime.run_until([] { return true; }, {});
      runtime.run_until([] { return false; }, {});
    });
    EXPECT_THAT(what, HasSubstr("no input"));
  });
}

/// Rank 0 decides on the failure in its own run and is gone when another rank fails in the run before: the
/// ranks that wait in that hear of it, too.
TEST_P(FailureOnRanks, FailuresInTwoRunsAtOnceEndBoth) {
  on_ranks(GetParam(), [&](Transport& transport) {
    const std::string what = failure_on(transport, [&](Runtime& runtime) {
      const bool leaves = runtime.rank() == Rank(0);
      runtime.run_until([&] { return leaves; },
                        [&](Context& context) {
                          if (context.rank() != Rank(last()) || leaves) return;
                          std::this_thread::sleep_for(std::chrono::milliseconds(50));
                          throw std::runtime_error("no input");
                        });
      runtime.run_until([] { return false; }, [](Context&) { throw std::runtime_error("no room"); });
    });
    EXPECT_THAT(what, ::testing::AnyOf(HasSubstr("no room"), HasSubstr("no input")));
  });
}

TEST(Failure, ARankThatFallsSilentInARunThatThisOneHasLeftCountsAsDead) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  LoopbackNetwork network(2);
  const Registry registry = bombs();
  Exchange silent(network.transport(Rank(0)), {}, registry.fingerprint());
  silent.begin_phase();
  silent.post(Rank(1), FrameKind::heartbeat, packed(std::uint64_t{1}));
  silent.progress([](Rank, FrameKind, Payload, std::size_t) {});
  Runtime runtime(network.transport(Rank(1)), registry,
                  {.silence = std::chrono::milliseconds(300), .on_failure = {}});
  runtime.run_until([] { return true; }, {});
  const auto time_of_end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const auto wait = [&] {
    runtime.run_until([&] { return std::chrono::steady_clock::now() > time_of_end; }, {});
  };
  EXPECT_EQ(what_of(wait), "rank 0 died: it has been silent for too long");
}

/// Packets may overtake each other.
TEST(Failure, ARankThatHasLeftCountsNotAsDeadWhenWhatItSentBeforeComesAfter) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  LoopbackNetwork network(2);
  const Registry registry = bombs();
  Exchange left(network.transport(Rank(0)), {}, registry.fingerprint());
  left.begin_phase();
  for (const FrameKind kind : {FrameKind::leaving, FrameKind::heartbeat}) {
    left.post(Rank(1), kind, packed(std::uint64_t{1}));
    left.progress([](Rank, FrameKind, Payload, std::size_t) {});
  }
  Runtime runtime(network.transport(Rank(1)), registry,
                  {.silence = std::chrono::milliseconds(100), .on_failure = {}});
  EXPECT_NO_THROW(runtime.run_until(
      [] { return true; }, [](Context&) { std::this_thread::sleep_for(std::chrono::milliseconds(800)); }));
}

/// Keeps its rank's worker busy beyond the end of the run in which it dies.
struct Heavy {
  ~Heavy() { std::this_thread::sleep_for(std::chrono::milliseconds(100)); }
  template <class Archive>
  void serialize(Archive&) {}
  void tick(Context&) {}
};

TEST_P(FailureOnRanks, NothingBeginsOnceTheRunHasFailed) {
  on_ranks(GetParam(), [&](Transport& transport) {
    Registry registry;
    registry.type<Heavy>("Heavy").method<&Heavy::tick>("tick");
    const auto over = std::make_shared<std::atomic<bool>>(false);
    const auto late = std::make_shared<std::atomic<bool>>(false);
    {
      Runtime runtime(transport, registry, {.on_failure = [](const std::string&) {}});
      runtime.run([](Context& context) { context.destroy(context.create<Heavy>()); });
      if (runtime.rank() == Rank(0)) runtime.request_stop("enough");
      // The root function's own variables are gone when the worker is free.
      EXPECT_THROW(runtime.run([=](Context&) { *late = over->load(); }), RunFailure);
      *over = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    EXPECT_FALSE(*late);
  });
}

TEST(Failure, ADeadRankIsNamedByTheOthersAndReportedOnce) {
  if (weft::testing::is_distributed())
    GTEST_SKIP() << "for one process; tests/engine/death_test.py kills processes";
  for (const int dead : {0, 2}) {
    LoopbackNetwork network(3);
    std::atomic<int> reporters{0};
    std::vector<std::thread> threads;
    for (int r = 0; r < 3; ++r) {
      if (r == dead) continue;
      threads.emplace_back([&, r] {
        const Registry registry = bombs();
        Runtime runtime(network.transport(Rank(r)), registry);
        try {
          runtime.run();
          ADD_FAILURE() << "the run ended without rank " << dead;
        } catch (const RunFailure& failure) {
          EXPECT_EQ(failure.what(), "rank " + std::to_string(dead) + " died: its process is gone");
          EXPECT_TRUE(failure.network_broken());
          reporters += failure.reported_here() ? 1 : 0;
        }
      });
    }
    network.kill(Rank(dead));
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(reporters, 1);
  }
}

TEST(Failure, ADeadRankIsNamedWhileReportsAreGathered) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  LoopbackNetwork network(3);
  std::vector<std::thread> threads;
  std::atomic<int> named{0};
  for (int r = 0; r < 3; ++r) {
    threads.emplace_back([&, r] {
      const Registry registry = bombs();
      Runtime runtime(network.transport(Rank(r)), registry, {.on_failure = {}});
      runtime.run();
      if (r == 2) return network.kill(Rank(2));  // rank 0 waits for its report, rank 1 for that of rank 0 ...
      try {
        runtime.gather_summaries();
        runtime.run();  // ... or for nobody, and comes here
      } catch (const RunFailure& failure) {
        EXPECT_STREQ(failure.what(), "rank 2 died: its process is gone");
        ++named;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(named, 2);
}

TEST(Failure, ASilentRankCountsAsDead) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  LoopbackNetwork network(2);
  // Rank 1 beats once and then hangs, inside its communication thread.
  std::thread hung([&] {
    const Registry registry = bombs();
    Runtime runtime(network.transport(Rank(1)), registry,
                    {.balancer = [](Rank, int) -> std::unique_ptr<Balancer> {
                      struct Hang final : Balancer {
                        void step(BalanceActions&, TimePoint) override {
                          if (++steps > 5) std::this_thread::sleep_for(std::chrono::seconds(3));
                        }
                        void told(Rank, const BalanceMessage&, BalanceActions&) override {}
                        int steps = 0;
                      };
                      return std::make_unique<Hang>();
                    }});
    EXPECT_THROW(runtime.run([](Context& context) {
      context.invoke<&Bomb::last_until_stopped>(context.create<Bomb>());
    }),
                 RunFailure);
  });
  const Registry registry = bombs();
  Runtime runtime(network.transport(Rank(0)), registry, {.silence = std::chrono::milliseconds(1500)});
  try {
    runtime.run();
    ADD_FAILURE() << "the run ended";
  } catch (const RunFailure& failure) {
    EXPECT_STREQ(failure.what(), "rank 1 died: it has been silent for too long");
  }
  hung.join();
}

}  // namespace
}  // namespace weft::engine::failure_test

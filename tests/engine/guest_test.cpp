// The engine as a guest of a program that uses MPI itself: on communicators of the caller, one after the
// other, with MPI initialised and finalised by the caller. Started by mpirun with any number of ranks.
#include <gtest/gtest.h>
#include <mpi.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "engine/mpi/mpi_transport.h"
#include "engine/run/launch.h"
#include "engine/run/runtime.h"
#include "tests/engine/transport_contract.h"
#include "tests/support/failing_new.h"

namespace weft::engine {
namespace {

using namespace std::chrono_literals;

int world_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int world_size() {
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

/// Ranks of one colour, numbered the other way round.
class SplitCommunicator {
 public:
  explicit SplitCommunicator(int colour) {
    MPI_Comm_split(MPI_COMM_WORLD, colour, -world_rank(), &communicator_);
  }
  ~SplitCommunicator() { MPI_Comm_free(&communicator_); }
  SplitCommunicator(const SplitCommunicator&) = delete;
  SplitCommunicator& operator=(const SplitCommunicator&) = delete;

  operator CallersCommunicator() const { return {&communicator_}; }
  MPI_Comm get() const { return communicator_; }

 private:
  MPI_Comm communicator_ = MPI_COMM_NULL;
};

void expect_mpi_runs() {
  EXPECT_TRUE(mpi_is_running());
  int sum = 0;
  const int one = 1;
  MPI_Allreduce(&one, &sum, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(sum, world_size());
}

void keep_contract(CallersCommunicator communicator, MpiTransportOptions options) {
  constexpr std::size_t kLargest = 1 << 18;
  MpiTransport transport(communicator, options);
  contract::Player player(transport);
  contract::keeps_contract([&](const std::function<void(contract::Player&)>& clause) { clause(player); },
                           kLargest,
                           options.shared_memory ? contract::kIdleShare : contract::kIdleShareWithoutBells);
  contract::closes_with_packets_in_flight(transport, kLargest);
  EXPECT_THROW(transport.send(transport.rank(), {}), TransportError);
}

TEST(Guest, KeepsTheContractOnTwoSplitCommunicatorsAtOnceAndThenOnTheWorld) {
  {
    const SplitCommunicator halves(world_rank() % 2);
    keep_contract(halves, {.chunk_bytes = 1000});
  }
  expect_mpi_runs();
  keep_contract(world_of_caller(), {.chunk_bytes = 1000});
  expect_mpi_runs();
}

TEST(Guest, KeepsTheContractWithoutSharedMemoryAsOnSeveralNodes) {
  keep_contract(world_of_caller(), {.chunk_bytes = 1000, .shared_memory = false});
  expect_mpi_runs();
}

TEST(Guest, RanksAreThoseOfTheCommunicator) {
  const SplitCommunicator reversed(0);
  MpiTransport transport(reversed);
  EXPECT_EQ(transport.size(), world_size());
  EXPECT_EQ(transport.rank(), Rank(world_size() - 1 - world_rank()));
  transport.close();
}

TEST(Guest, SeveralTransportsMayBeOpenAtOnce) {
  const SplitCommunicator reversed(0);
  MpiTransport one(world_of_caller()), two(reversed);
  contract::Player on_one(one), on_two(two);
  contract::all_to_all(on_one, 10, 1000);
  contract::all_to_all(on_two, 10, 1000);
  two.close();
  contract::all_to_all(on_one, 10, 1000);
  one.close();
  expect_mpi_runs();
}

TEST(Guest, WorksOnTheCommunicatorOfThisProcessAlone) {
  const MPI_Comm self = MPI_COMM_SELF;
  for (int time = 0; time < 3; ++time) {
    MpiTransport transport(CallersCommunicator{&self});
    EXPECT_EQ(transport.size(), 1);
    contract::Player player(transport);
    contract::self_sends(player);
    transport.close();
  }
  expect_mpi_runs();
}

TEST(Guest, LeavesTheErrorHandlersOfTheCallerAlone) {
  const SplitCommunicator split(0);
  MPI_Comm_set_errhandler(split.get(), MPI_ERRORS_ARE_FATAL);
  { MpiTransport(split).close(); }
  for (const MPI_Comm communicator : {split.get(), MPI_Comm(MPI_COMM_WORLD), MPI_Comm(MPI_COMM_SELF)}) {
    MPI_Errhandler handler = MPI_ERRHANDLER_NULL;
    MPI_Comm_get_errhandler(communicator, &handler);
    EXPECT_EQ(handler, MPI_ERRORS_ARE_FATAL);
    MPI_Errhandler_free(&handler);
  }
}

TEST(Guest, RefusesWhatIsNoIntracommunicator) {
  const MPI_Comm null = MPI_COMM_NULL;
  EXPECT_THROW(MpiTransport(CallersCommunicator{&null}), TransportError);
  EXPECT_THROW(MpiTransport(CallersCommunicator{}), TransportError);
  EXPECT_THROW(MpiTransport(nullptr, nullptr), TransportError) << "MPI is the caller's";
}

TEST(Guest, AnAbandonedNetworkIsUsedNoMoreButMpiAndTheOtherRanksGoOn) {
  const SplitCommunicator all(0);
  {
    MpiTransport transport(all);
    contract::Player player(transport);
    player.meet();
    if (transport.rank() == Rank(0)) {
      transport.abandon();
      EXPECT_THROW(transport.send(Rank(0), {}), TransportError);
      EXPECT_THROW(player.poll(), TransportError);
      EXPECT_THROW(transport.close(), TransportError);
      transport.wake();
      MPI_Barrier(all.get());
    } else {
      player.until([&] { return transport.lost_peer().has_value(); });
      EXPECT_EQ(transport.lost_peer()->rank, Rank(0));
      EXPECT_FALSE(transport.lost_peer()->will_close);
      MPI_Barrier(all.get());  // one that leaves is lost too
      EXPECT_THROW(transport.close(), TransportError);
      // Neither closed nor abandoned: the destructor abandons.
    }
  }
  expect_mpi_runs();
  keep_contract(all, {});  // a new one does
}

/// Sets a limit of this process for as long as it lives.
class Limit {
 public:
  Limit(__rlimit_resource resource, rlim_t value) : resource_(resource) {
    getrlimit(resource_, &before_);
    const rlimit limit{std::min(value, before_.rlim_max), before_.rlim_max};
    setrlimit(resource_, &limit);
  }
  ~Limit() { setrlimit(resource_, &before_); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  __rlimit_resource resource_;
  rlimit before_{};
};

TEST(Guest, ToRunOutOfFileDescriptorsIsNobodysDeath) {
  MpiTransport transport(world_of_caller());
  {
    const Limit no_files(RLIMIT_NOFILE, 0);
    EXPECT_FALSE(transport.lost_peer());
  }
  EXPECT_FALSE(transport.lost_peer());
  transport.close();
}

rlim_t address_space_in_use() {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  statm >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

TEST(Guest, ARankWithoutMemoryForAPacketFailsTheNetworkInsteadOfWaitingForEver) {
  if (world_size() == 1) GTEST_SKIP() << "for several ranks";
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "an allocation that fails ends a process under the address sanitizer";
#endif
  {
    MpiTransport transport(world_of_caller());
    contract::Player player(transport);
    if (transport.rank() != Rank(1)) player.meet();
    if (transport.rank() == Rank(0)) {
      std::vector<Blob> segments;
      segments.push_back(Blob::allocate(std::size_t{1} << 30));
      player.send(Rank(1), {}, std::move(segments));
    }
    if (transport.rank() == Rank(1)) {
      const Limit memory(RLIMIT_AS, address_space_in_use() + (rlim_t{256} << 20));
      const auto meet_and_receive = [&] {  // the packet may come before the meeting has ended here
        player.meet();
        player.until([&] { return player.has_mail(); });
      };
      EXPECT_THROW(meet_and_receive(), TransportError);
      EXPECT_THROW(player.poll(), TransportError) << "for good";
      transport.abandon();
    } else {
      player.until([&] { return transport.lost_peer().has_value(); });
      EXPECT_EQ(transport.lost_peer()->rank, Rank(1));
    }
    MPI_Barrier(MPI_COMM_WORLD);  // who leaves first is another rank lost to the rest
  }
  expect_mpi_runs();
}

/// A head that MPI does not take over at once, and one with more segments than fit behind it.
Packet head_alone() { return {std::vector<std::byte>(Transport::kMaxHead), {}}; }
Packet many_segments() {
  Packet packet;
  for (int i = 0; i < 70; ++i) packet.segments.push_back(Blob::allocate(100));
  return packet;
}

/// Sends to rank 1; whether an allocation has failed, which must be the end of the network.
bool fails_by_allocation(int number, MpiTransport& transport, Packet packet) {
  std::string thrown = "nothing";
  bool failed = false;
  {
    const weft::testing::FailingNew memory(number);
    try {
      transport.send(Rank(1), std::move(packet));
    } catch (const TransportError&) {
      thrown.clear();
    } catch (const std::exception& error) {
      thrown = error.what();
    }
    failed = memory.has_failed();
  }
  if (!failed) return false;
  EXPECT_EQ(thrown, "") << "allocation " << number;
  EXPECT_THROW(transport.send(Rank(1), {}), TransportError) << "for good, allocation " << number;
  return true;
}

/// On a network of its own.
bool send_fails_by_allocation(int number, Packet packet) {
  MpiTransport transport(world_of_caller());
  contract::Player player(transport);
  int failed = transport.rank() == Rank(0) && fails_by_allocation(number, transport, std::move(packet));
  MPI_Bcast(&failed, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (!failed) {
    transport.close();
  } else if (transport.rank() == Rank(0)) {
    transport.abandon();
  } else {
    player.until([&] { return transport.lost_peer().has_value(); });
  }
  MPI_Barrier(MPI_COMM_WORLD);  // who leaves first is another rank lost to the rest
  return failed != 0;
}

/// Else the receivers would wait in close() for what never comes, or MPI would read what has been freed.
TEST(Guest, ARankWithoutMemoryToSendFailsTheNetworkWhicheverAllocationItIs) {
  if (world_size() == 1) GTEST_SKIP() << "for several ranks";
  if (!weft::testing::kNewCanFail) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  for (const auto& packet : {head_alone, many_segments}) {
    int number = 0;
    while (send_fails_by_allocation(number, packet())) ++number;
    EXPECT_GT(number, 0);
  }
  expect_mpi_runs();
}

// --- run_on

struct Counter {
  int calls = 0;
  void count(Context&) { ++calls; }
  void fail(Context&) { throw std::runtime_error("too late"); }
  void last_until_stopped(Context& context) {
    while (!context.stop_requested()) std::this_thread::sleep_for(1ms);
  }
};

Registry counters() {
  Registry registry;
  registry.type<Counter>("Counter")
      .method<&Counter::count>("count")
      .method<&Counter::fail>("fail")
      .method<&Counter::last_until_stopped>("last_until_stopped");
  return registry;
}

/// Every rank calls rank 0's counter; on rank 0 how often it was called.
int count_calls(Transport& transport) {
  const Registry registry = counters();
  Runtime runtime(transport, registry);
  const MobilePtr<Counter> counter{{Rank(0), 1}};
  runtime.run([&](Context& context) {
    if (context.rank() == Rank(0)) context.create<Counter>();
    context.invoke<&Counter::count>(counter);
  });
  int calls = 0;
  runtime.visit<Counter>([&](MobilePtr<Counter>, Counter& each) { calls += each.calls; });
  return calls;
}

TEST(RunOn, RunsOnOneCommunicatorAfterTheOther) {
  for (int time = 0; time < 3; ++time) {
    const SplitCommunicator halves(world_rank() % 2);
    run_on(halves, [](Transport& transport) {
      const int calls = count_calls(transport);
      EXPECT_EQ(calls, transport.rank() == Rank(0) ? transport.size() : 0);
    });
    expect_mpi_runs();
  }
}

/// What run_on() throws on this rank, and that all come out of it.
std::string failure_of(const std::function<void(Transport&)>& body) {
  std::string what;
  try {
    run_on(world_of_caller(), body);
  } catch (const RunFailure& failure) {
    what = std::string("RunFailure: ") + failure.what();
    EXPECT_FALSE(failure.network_broken());
  } catch (const std::exception& error) {
    what = error.what();
  }
  expect_mpi_runs();
  return what;
}

TEST(RunOn, WhatAllRanksThrowIsThrownOnEach) {
  EXPECT_EQ(failure_of([](Transport& transport) {
              count_calls(transport);
              throw std::runtime_error("no such file");
            }),
            "no such file");
}

class RunOnWithOneFailing : public ::testing::Test {
 protected:
  const int guilty_ = world_size() - 1;
  std::string expected(const std::string& of_the_others) const {
    return world_rank() == guilty_ ? "no such file"
                                   : "RunFailure: rank " + std::to_string(guilty_) + " " + of_the_others;
  }
};

TEST_F(RunOnWithOneFailing, TheOthersAreNotLeftWaitingInARun) {
  EXPECT_EQ(failure_of([&](Transport& transport) {
              count_calls(transport);
              if (world_rank() == guilty_) throw std::runtime_error("no such file");
              count_calls(transport);
            }),
            expected("has failed: no such file"));
}

TEST_F(RunOnWithOneFailing, TheOthersAreNotLeftWaitingWhileReportsAreGathered) {
  EXPECT_EQ(failure_of([&](Transport& transport) {
              const Registry registry = counters();
              Runtime runtime(transport, registry);
              runtime.run();
              if (world_rank() == guilty_) throw std::runtime_error("no such file");
              runtime.gather_summaries();
              // A rank whose own report was all that it had to see to has come through.
              runtime.run();
            }),
            expected("has failed: no such file"));
}

TEST_F(RunOnWithOneFailing, TheOthersThrowThoughTheyHadNothingMoreToDo) {
  EXPECT_EQ(failure_of([&](Transport& transport) {
              count_calls(transport);
              if (world_rank() == guilty_) throw std::runtime_error("no such file");
            }),
            expected("has failed: no such file"));
}

TEST_F(RunOnWithOneFailing, AFailingHandlerFailsTheRunOnAllRanks) {
  const std::string what = failure_of([&](Transport& transport) {
    const Registry registry = counters();
    Runtime runtime(transport, registry, {.on_failure = {}});
    runtime.run([&](Context& context) {
      context.invoke<&Counter::last_until_stopped>(context.create<Counter>());
      if (context.rank() == Rank(guilty_)) throw std::runtime_error("no such file");
    });
  });
  EXPECT_EQ(what, "RunFailure: the root function on rank " + std::to_string(guilty_) + ": no such file");
}

TEST(RunOn, AHandlerThatDoesNotStopDoesNotEndTheProcess) {
  try {
    run_on(world_of_caller(), [&](Transport& transport) {
      const Registry registry = counters();
      Runtime runtime(transport, registry, {.grace = 100ms, .on_failure = {}});
      // The last rank fails while rank 0 sleeps, not before.
      const MobilePtr<Counter> failing{{Rank(world_size() - 1), 1}};
      runtime.run([&](Context& context) {
        if (context.rank() == Rank(world_size() - 1)) context.create<Counter>();
        if (context.rank() != Rank(0)) return;
        context.invoke<&Counter::fail>(failing);
        std::this_thread::sleep_for(1s);
      });
    });
    ADD_FAILURE() << "the run did not fail";
  } catch (const RunFailure& failure) {
    EXPECT_TRUE(failure.network_broken() || world_size() == 1);
  }
  expect_mpi_runs();
}

TEST(Launch, IsAGuestWhereMpiRunsAlready) {
  const int status = launch(0, nullptr, [](Transport& transport) {
    EXPECT_EQ(transport.size(), world_size());
    count_calls(transport);
    return 7;
  });
  EXPECT_EQ(status, 7);
  expect_mpi_runs();
}

TEST(Launch, AStatusOfOneRankAloneFailsTheRunsOfTheOthers) {
  const int status = launch(0, nullptr, [](Transport& transport) {
    count_calls(transport);
    if (world_rank() == world_size() - 1) return 3;
    count_calls(transport);
    return 0;
  });
  EXPECT_EQ(status, world_rank() == world_size() - 1 ? 3 : kExitFailed);
  expect_mpi_runs();
}

}  // namespace
}  // namespace weft::engine

/// After the end of MPI; 0 where it is said that there is only one.
static int start_again() {
  try {
    weft::engine::MpiTransport again(nullptr, nullptr);
  } catch (const weft::engine::TransportError& error) {
    if (std::string_view(error.what()).starts_with("MPI has been ended")) return 0;
    std::fprintf(stderr, "guest_test: %s\n", error.what());
  }
  return 1;
}

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  MPI_Init(&argc, &argv);  // at the lowest thread level, as old programs do
  int result = RUN_ALL_TESTS();
  if (!weft::engine::mpi_is_running()) {
    std::fprintf(stderr, "guest_test: somebody has finalised MPI\n");
    return 1;
  }
  MPI_Finalize();
  return result != 0 ? result : start_again();
}

// MpiTransport keeps the transport contract; started by mpirun with any number of ranks, each of which runs
// every test.
// --a-rank-dies: instead, the last rank kills itself, and the others find out (mpirun --enable-recovery).
#include "engine/mpi/mpi_transport.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>

#include "engine/mpi/mpi_calls.h"
#include "tests/engine/transport_contract.h"

namespace weft::engine {
namespace {

using namespace std::chrono_literals;
using contract::Player;

/// Small, so that most segments of the tests go in several messages.
constexpr MpiTransportOptions kOptions{.chunk_bytes = 1000};
constexpr std::size_t kLargest = 1 << 20;

Player* player = nullptr;

TEST(MpiTransport, PacketsOfAllShapesArrive) { contract::shapes_arrive(*player, kLargest); }
TEST(MpiTransport, MisuseIsRefused) { contract::misuse_is_refused(*player); }
TEST(MpiTransport, SelfSends) { contract::self_sends(*player); }
TEST(MpiTransport, RandomTrafficArrivesOnceAndWhole) { contract::all_to_all(*player, 60, kLargest / 8); }
TEST(MpiTransport, ReceiversMaySend) { contract::receivers_may_send(*player, 50); }
TEST(MpiTransport, ReceiversMayThrow) { contract::receivers_may_throw(*player); }
TEST(MpiTransport, WakeEndsWaitAndIsRemembered) { contract::wakes(*player); }
TEST(MpiTransport, IdlesCheaply) { contract::idles_cheaply(*player); }
TEST(MpiTransport, SleepersWakeSoon) { contract::sleepers_wake_soon(*player); }
TEST(MpiTransport, SmallPacketsPassLargeOnes) { contract::small_pass_large(*player, kLargest); }
TEST(MpiTransport, NobodyIsDead) { contract::nobody_is_dead(*player); }
TEST(MpiTransport, MakesNoCollectiveCallWhileItRuns) {
  contract::no_collective_calls(*player, is_collective);
}

TEST(MpiTransport, CountsItsCalls) {
  long sends = 0, starts = 0;
  for (const auto& [name, count] : player->transport().calls()) {
    if (name == "MPI_Init_thread") starts = count;
    if (name == "MPI_Isend") sends = count;
  }
  EXPECT_EQ(starts, 1);
  EXPECT_EQ(sends > 0, player->size() > 1);
  player->meet();
}

TEST(MpiTransport, IsOneOfAKind) {
  EXPECT_THROW(MpiTransport(nullptr, nullptr), TransportError);
  EXPECT_TRUE(under_mpirun() || player->size() == 1);
  player->meet();
}

TEST(MpiCalls, KnowsCollectivesByName) {
  for (const char* name :
       {"MPI_Allreduce", "MPI_Ibcast", "MPI_Ineighbor_alltoallw", "MPI_Barrier", "MPI_Allreduce_init",
        "MPI_Comm_dup", "MPI_Comm_idup", "MPI_Win_fence", "MPI_File_write_all", "MPI_Init_thread",
        "MPI_Finalize", "MPI_Bcast_c", "MPI_Cart_create", "MPI_Win_allocate_shared"}) {
    EXPECT_TRUE(is_collective(name)) << name;
  }
  for (const char* name :
       {"MPI_Isend", "MPI_Irecv", "MPI_Testsome", "MPI_Recv_init", "MPI_Start", "MPI_Iprobe", "MPI_Put",
        "MPI_Abort", "MPI_Initialized", "MPI_Comm_rank", "MPI_Wtime", "MPI_Win_lock_all"}) {
    EXPECT_FALSE(is_collective(name)) << name;
  }
  player->meet();
}

/// Of the other ranks, only failures are of interest.
class FailuresOnly : public testing::EmptyTestEventListener {
 public:
  explicit FailuresOnly(Rank rank) : rank_(rank) {}

 private:
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::fprintf(stderr, "rank %d: %s:%d: %s\n", rank_.value, result.file_name() ? result.file_name() : "?",
                 result.line_number(), result.message());
  }

  Rank rank_;
};

int run_tests(MpiTransport& transport) {
  if (transport.rank() != Rank(0)) {
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailuresOnly(transport.rank()));
  }
  Player one(transport);
  player = &one;
  const int result = RUN_ALL_TESTS();
  contract::closes_with_packets_in_flight(transport, kLargest);
  return result;
}

/// Ends by abandon(), as a program would whose peer has died.
int lose_a_rank(MpiTransport& transport) {
  Player me(transport);
  const Rank victim(transport.size() - 1);
  me.meet();
  if (me.rank() == victim) std::raise(SIGKILL);
  if (me.rank() != Rank(0)) std::this_thread::sleep_for(20s);  // until rank 0 ends it all
  const auto start = contract::Clock::now();
  while (!transport.lost_peer() && contract::Clock::now() - start < 10s) {
    me.poll();
    transport.wait(1ms);
  }
  const double seconds = std::chrono::duration<double>(contract::Clock::now() - start).count();
  const auto dead = transport.lost_peer();
  std::printf("found dead: %d after %.3f s\n", dead ? dead->rank.value : -1, seconds);
  try {
    transport.close();
  } catch (const TransportError& error) {
    std::printf("close refused: %s\n", error.what());
  }
  std::fflush(stdout);
  transport.abandon();
  return EXIT_FAILURE;  // abandon() does not return
}

}  // namespace
}  // namespace weft::engine

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  try {
    weft::engine::MpiTransport transport(&argc, &argv, weft::engine::kOptions);
    if (argc > 1 && std::strcmp(argv[1], "--a-rank-dies") == 0) return weft::engine::lose_a_rank(transport);
    return weft::engine::run_tests(transport);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mpi_transport_test: %s\n", error.what());
    return EXIT_FAILURE;
  }
}

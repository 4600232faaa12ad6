// Runs a test on several ranks: threads of this process, or, when it was started by mpirun, its processes.
#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <functional>
#include <vector>

#include "engine/network/transport.h"

namespace weft::testing {

/// The numbers of ranks that tests are run with: 1, 2, 3 and 8 in one process; what there are under mpirun.
std::vector<int> rank_counts();

/// True when each rank is a process.
bool is_distributed();

/// True in the first process of mpirun, and without mpirun.
bool is_first_process();

/// Calls `function` on each of `ranks` ranks with its transport, and waits for all of them. Expectations may
/// be checked on any rank. An exception that leaves it on any rank fails the test.
void on_ranks(int ranks, const std::function<void(engine::Transport&)>& function);

/// A transport that delivers packets late and in another order: up to `longest` later, at random.
std::unique_ptr<engine::Transport> delayed(engine::Transport& transport, std::chrono::microseconds longest,
                                           unsigned seed);

/// Scales the sizes of tests down where sanitizers make everything slow.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSlowness = 10;
#else
inline constexpr int kSlowness = 1;
#endif

/// Instantiate a suite of TEST_P with the rank counts.
class OnRanks : public ::testing::TestWithParam<int> {};

}  // namespace weft::testing

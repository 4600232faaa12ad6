// What all ranks hear of one, or throw because of it.
#include "partition/communication/agreement.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "meshing/base/error.h"
#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::agreement_test {
namespace {

TEST(TextOfFirstOrThrow, AllRanksHearTheTextInOneExchange) {
  for (const int ranks : support::kNumbersOfRanks)
    for (const std::string text : {"", "-", "a name"})
      support::run_ranks(ranks, [&](Peers& peers) {
        support::CountingPeers counting(peers);
        const auto action = [&] {
          EXPECT_EQ(peers.rank(), 0);
          return text;
        };
        EXPECT_EQ(text_of_first_or_throw(counting, action), text);
        EXPECT_EQ(counting.exchanges, 1u);
      });
}

TEST(TextOfFirstOrThrow, AllRanksThrowWhatTheFirstDoes) {
  for (const int ranks : support::kNumbersOfRanks)
    support::run_ranks(ranks, [](Peers& peers) {
      const auto action = []() -> std::string { throw std::runtime_error("no room"); };
      try {
        text_of_first_or_throw(peers, action);
        ADD_FAILURE() << "rank " << peers.rank() << " does not throw";
      } catch (const meshing::InputError& error) {
        EXPECT_STREQ(error.what(), "no room");
      }
    });
}

}  // namespace
}  // namespace weft::partition::agreement_test

// Ranks that compute otherwise are found before anything is decided.
#include "partition/communication/same_arithmetic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "meshing/base/error.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::partition::same_arithmetic_test {
namespace {

TEST(SameArithmetic, TheFingerprintIsTheSameEachTime) {
  EXPECT_EQ(arithmetic_fingerprint(), arithmetic_fingerprint());
  EXPECT_NE(arithmetic_fingerprint(), 0u);
}

TEST(SameArithmetic, RanksOfOneProcessAgree) {
  for (const int ranks : support::kNumbersOfRanks)
    EXPECT_NO_THROW(support::run_ranks(ranks, [](Peers& peers) { check_same_arithmetic(peers); }));
}

TEST(SameArithmetic, AllRanksRefuseWhenOneDiffers) {
  const auto thrown = support::run_ranks_caught(
      4, [](Peers& peers) { check_same_arithmetic(peers, arithmetic_fingerprint() + (peers.rank() == 2)); });
  for (const std::exception_ptr& e : thrown) {
    ASSERT_TRUE(e);
    try {
      std::rethrow_exception(e);
    } catch (const meshing::InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("rank 2 computes exp, log"));
    }
  }
}

}  // namespace
}  // namespace weft::partition::same_arithmetic_test

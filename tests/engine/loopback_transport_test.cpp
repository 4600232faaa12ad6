// LoopbackTransport keeps the transport contract, and so does the transport that delays packets in tests.
#include "engine/network/loopback_transport.h"

#include <gtest/gtest.h>

#include "tests/engine/transport_contract.h"
#include "tests/support/ranks.h"

namespace weft::engine::loopback_transport_test {
namespace {

using contract::Player;

/// Runs a part of the contract with 1 to 4 ranks in threads, plain and delayed.
void keep(const std::function<void(Player&)>& part) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  for (const int ranks : {1, 2, 4}) {
    weft::testing::on_ranks(ranks, [&](Transport& transport) {
      Player player(transport);
      part(player);
    });
    weft::testing::on_ranks(ranks, [&](Transport& transport) {
      const auto late = weft::testing::delayed(transport, std::chrono::microseconds(300), 1);
      Player player(*late);
      part(player);
    });
  }
}

TEST(LoopbackTransport, PacketsOfAllShapesArrive) {
  keep([](Player& player) { contract::shapes_arrive(player, 1 << 20); });
}
TEST(LoopbackTransport, MisuseIsRefused) { keep(contract::misuse_is_refused); }
TEST(LoopbackTransport, SelfSends) { keep(contract::self_sends); }
TEST(LoopbackTransport, RandomTrafficArrivesOnceAndWhole) {
  keep([](Player& player) { contract::all_to_all(player, 60, 1 << 17); });
}
TEST(LoopbackTransport, ReceiversMaySend) {
  keep([](Player& player) { contract::receivers_may_send(player, 50); });
}
TEST(LoopbackTransport, ReceiversMayThrow) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  weft::testing::on_ranks(2, [](Transport& transport) {
    Player player(transport);
    contract::receivers_may_throw(player);
  });
}
TEST(LoopbackTransport, WakeEndsWaitAndIsRemembered) { keep(contract::wakes); }
TEST(LoopbackTransport, NobodyIsDead) { keep(contract::nobody_is_dead); }

}  // namespace
}  // namespace weft::engine::loopback_transport_test

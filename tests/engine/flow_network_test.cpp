// SimGrid's networks: single packets whose times are known, shared links, and programs of the engine on them.
#include "engine/simulate/flow_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <limits>
#include <map>
#include <stdexcept>
#include <vector>

#include "engine/run/runtime.h"
#include "engine/simulate/simulation.h"

namespace weft::engine {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t kMegabyte = 1'000'000;  // a millisecond at 1 GB/s

NetworkModel network_of(Topology topology, int switch_ranks) {
  return {.latency = 1e-6, .bandwidth = 1e9, .topology = topology, .switch_ranks = switch_ranks};
}

struct Sent {
  int from, to;
  std::size_t bytes = kMegabyte;
  std::int64_t time = 0;
};

class FlowNetworkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!WEFT_HAS_SIMGRID) GTEST_SKIP() << "SimGrid is not installed: scripts/setup.sh --all";
  }
};

/// When each of the packets arrives, in the order in which they were sent.
std::vector<std::int64_t> arrivals(const NetworkModel& model, int ranks, const std::vector<Sent>& packets) {
  const auto network = make_flow_network(model, ranks);
  for (std::size_t i = 0; i < packets.size(); ++i)
    network->send(i, Rank(packets[i].from), Rank(packets[i].to), packets[i].bytes, packets[i].time);
  std::vector<std::int64_t> times(packets.size(), -1);
  for (std::size_t seen = 0; seen < packets.size();)
    for (const auto& arrival : network->advance(kNever)) times.at(arrival.packet) = arrival.time, ++seen;
  EXPECT_THAT(network->advance(kNever), IsEmpty());
  return times;
}

TEST_F(FlowNetworkTest, A_packet_takes_latency_and_bandwidth) {
  const auto times = arrivals(network_of(Topology::fat_tree, 4), 16,
                              {{0, 1}, {4, 8, kMegabyte, 5'000'000}, {8, 9, 1, 7'000'000}});
  EXPECT_NEAR(times[0], 1'001'000, 2) << "two links of half the latency";
  EXPECT_NEAR(times[1], 6'002'000, 2) << "four, by a switch above";
  EXPECT_NEAR(times[2], 7'001'000, 3);
}

TEST_F(FlowNetworkTest, Flows_to_one_port_share_it) {
  const auto times = arrivals(network_of(Topology::fat_tree, 8), 8, {{0, 2}, {1, 2}, {3, 4}});
  EXPECT_NEAR(times[0], 2'001'000, 3);
  EXPECT_NEAR(times[1], 2'001'000, 3);
  EXPECT_NEAR(times[2], 1'001'000, 3) << "another port is not concerned";
}

TEST_F(FlowNetworkTest, A_later_flow_slows_one_that_is_under_way) {
  const auto times = arrivals(network_of(Topology::fat_tree, 8), 8, {{0, 2}, {1, 2, kMegabyte, 500'000}});
  EXPECT_NEAR(times[0], 1'501'000, 600) << "half of it alone, the rest at half the speed";
  EXPECT_NEAR(times[1], 2'001'000, 600);
}

TEST_F(FlowNetworkTest, Uplinks_of_a_fat_tree_have_half_the_bandwidth) {
  std::vector<Sent> all;
  for (int r = 0; r < 4; ++r) all.push_back({r, r + 4});
  const auto times = arrivals(network_of(Topology::fat_tree, 4), 8, all);
  EXPECT_NEAR(*std::max_element(times.begin(), times.end()), 2'002'000, 5)
      << "four ports of 1 GB/s, two uplinks";
}

TEST_F(FlowNetworkTest, Groups_of_a_dragonfly_share_their_links) {
  // Nine routers of two ranks in three groups of three: all six ranks of a group send to the next one.
  std::vector<Sent> far, near;
  for (int r = 0; r < 6; ++r) far.push_back({r, r + 6});
  for (int r = 0; r < 6; r += 2) near.push_back({r, r + 1});
  const NetworkModel model = network_of(Topology::dragonfly, 2);
  const auto apart = arrivals(model, 18, far);
  EXPECT_NEAR(*std::max_element(apart.begin(), apart.end()), 6'000'000, 10'000)
      << "one link joins two groups";
  const auto together = arrivals(model, 18, near);
  EXPECT_NEAR(*std::max_element(together.begin(), together.end()), 1'001'000, 5) << "on one router";
}

TEST_F(FlowNetworkTest, Signals_stay_the_programs_own) {
  const auto mine = [](int) {};
  const auto before = std::signal(SIGINT, mine);
  const auto network = make_flow_network(network_of(Topology::fat_tree, 4), 4);
  EXPECT_TRUE(std::signal(SIGINT, before) == +mine);
}

TEST_F(FlowNetworkTest, Goes_no_further_than_it_is_asked_to) {
  const auto network = make_flow_network(network_of(Topology::fat_tree, 4), 4);
  network->send(7, Rank(0), Rank(1), kMegabyte, 100);
  EXPECT_THAT(network->advance(500'000), IsEmpty());
  network->send(8, Rank(2), Rank(3), 1'000, 500'000);
  const auto first = network->advance(kNever);
  ASSERT_THAT(first, SizeIs(1));
  EXPECT_EQ(first[0].packet, 8u);
  EXPECT_NEAR(first[0].time, 502'000, 5);
  const auto second = network->advance(kNever);
  ASSERT_THAT(second, SizeIs(1));
  EXPECT_EQ(second[0].packet, 7u);
  EXPECT_NEAR(second[0].time, 1'001'100, 5);
}

/// Each rank tells its number to the next, which adds it to what it knows, until it has gone round.
struct Ring {
  long sum = 0;
  void pass(Context& context, int hops, long number) {
    sum += number;
    const Rank next((context.rank().value + 1) % context.ranks());
    if (hops > 0) context.invoke<&Ring::pass>(MobilePtr<Ring>{{next, 1}}, hops - 1, number);
  }
};

struct Rings {
  std::vector<long> sums;
  SimulationResult result;
};

Rings rings(const char* network, int ranks) {
  Rings rings;
  SimulationOptions options;
  options.ranks = ranks;
  options.measured = false;
  options.network = parse_network(network);
  rings.result = simulate(options, [&](Transport& transport) {
    Registry registry;
    registry.type<Ring>("Ring").method<&Ring::pass>("pass");
    Runtime runtime(transport, registry, {.balancer = no_balancing()});
    runtime.run([&](Context& context) {
      context.invoke<&Ring::pass>(context.create<Ring>(), ranks - 1, long{context.rank().value});
    });
    runtime.visit<Ring>([&](MobilePtr<Ring>, Ring& ring) { rings.sums.push_back(ring.sum); });
  });
  return rings;
}

TEST_F(FlowNetworkTest, Programs_run_on_it_as_on_the_first_model) {
  constexpr int kRanks = 24;
  std::map<std::string, Rings> by_network;
  for (const char* network : {"2us,10GB/s", "2us,10GB/s,fat-tree:4", "2us,10GB/s,dragonfly:2"})
    by_network[network] = rings(network, kRanks);
  for (const auto& [network, run] : by_network) {
    EXPECT_EQ(run.sums, std::vector<long>(kRanks, kRanks * (kRanks - 1) / 2)) << network;
    EXPECT_GT(run.result.seconds, kRanks * 2e-6) << network;
    EXPECT_LT(run.result.seconds, 1e-3) << network;
  }
  EXPECT_GT(by_network["2us,10GB/s,fat-tree:4"].result.seconds, by_network["2us,10GB/s"].result.seconds)
      << "some hops are by a switch above";
}

struct Sink {
  std::size_t taken = 0;
  void take(Context&, const std::vector<double>& values) { taken += values.size(); }
};

/// Waves that look for the end pass a message of 200 kB at 1 kB/s for minutes.
TEST_F(FlowNetworkTest, A_packet_that_takes_minutes_is_not_lost) {
  constexpr std::size_t kNumbers = 25'000;
  SimulationOptions options;
  options.ranks = 2;
  options.measured = false;
  options.network = {.latency = 1e-3, .bandwidth = 1e3, .topology = Topology::fat_tree, .switch_ranks = 2};
  std::size_t taken = 0;
  const SimulationResult result = simulate(options, [&](Transport& transport) {
    Registry registry;
    registry.type<Sink>("Sink").method<&Sink::take>("take");
    Runtime runtime(transport, registry, {.balancer = no_balancing()});
    runtime.run([](Context& context) {
      if (context.rank() == Rank(1)) {
        context.create<Sink>();
      } else {
        context.invoke<&Sink::take>(MobilePtr<Sink>{{Rank(1), 1}}, std::vector<double>(kNumbers));
      }
    });
    runtime.visit<Sink>([&](MobilePtr<Sink>, Sink& sink) { taken += sink.taken; });
  });
  EXPECT_EQ(taken, kNumbers);
  EXPECT_GT(result.seconds, 200);
}

TEST_F(FlowNetworkTest, Every_simulation_takes_the_same_turns) {
  const Rings first = rings("2us,1GB/s,dragonfly:2", 12), second = rings("2us,1GB/s,dragonfly:2", 12);
  EXPECT_EQ(first.result.turns, second.result.turns);
  EXPECT_EQ(first.result.packets, second.result.packets);
  EXPECT_EQ(first.result.seconds, second.result.seconds);
}

TEST(FlowNetworks, Without_SimGrid_the_package_is_named) {
  if (WEFT_HAS_SIMGRID) GTEST_SKIP() << "SimGrid is installed";
  try {
    make_flow_network(network_of(Topology::fat_tree, 4), 8);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("libsimgrid-dev"));
  }
}

}  // namespace
}  // namespace weft::engine

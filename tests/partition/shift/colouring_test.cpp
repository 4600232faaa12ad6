// The colouring played on random graphs.
#include "partition/shift/colouring.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace weft::partition::colouring_test {
namespace {

using Graph = std::vector<std::vector<SubdomainId>>;

Graph random_graph(std::uint32_t n, double density, std::mt19937& random) {
  Graph graph(n);
  std::bernoulli_distribution joined(density);
  for (std::uint32_t a = 0; a < n; ++a)
    for (std::uint32_t b = a + 1; b < n; ++b)
      if (joined(random)) graph[a].emplace_back(b), graph[b].emplace_back(a);
  return graph;
}

/// Whether a subdomain receives from all its neighbours: what SubdomainTask::gather goes by.
bool receives(const Priority& self, std::vector<Priority> neighbours) {
  std::sort(neighbours.begin(), neighbours.end(),
            [](const Priority& a, const Priority& b) { return a.id < b.id; });
  const ReceiverOrder order(self, neighbours);
  std::vector<Holder> others;
  for (const Priority& p : neighbours) others.push_back({GlobalId(), p.id});
  EXPECT_EQ(order.above_self() == 0, order.receiver(others) == order.self());
  return order.above_self() == 0;
}

/// Who receives among those that take part.
std::vector<bool> receivers(const Graph& graph, const std::vector<Priority>& priorities,
                            const std::vector<bool>& takes_part) {
  std::vector<bool> result(graph.size(), false);
  for (std::uint32_t s = 0; s < graph.size(); ++s) {
    std::vector<Priority> neighbours;
    for (const SubdomainId n : graph[s])
      if (takes_part[n.value]) neighbours.push_back(priorities[n.value]);
    result[s] = takes_part[s] && receives(priorities[s], neighbours);
  }
  return result;
}

/// Few values, so that ties are common.
std::vector<Priority> draw(std::uint32_t n, std::mt19937& random) {
  std::vector<Priority> priorities(n);
  for (std::uint32_t s = 0; s < n; ++s) priorities[s] = {random() % 5, SubdomainId(s)};
  return priorities;
}

class OnRandomGraphs : public ::testing::TestWithParam<double> {
 protected:
  template <class Check>
  void for_graphs(const Check& check) {
    for_graphs_up_to(80, check);
  }
  template <class Check>
  void for_graphs_up_to(std::uint32_t most, const Check& check) {
    std::mt19937 random(7);
    for (int repeat = 0; repeat < 30; ++repeat) {
      const std::uint32_t n = 1 + random() % most;
      check(random_graph(n, GetParam(), random), random);
    }
  }
};

TEST_P(OnRandomGraphs, NoNeighboursReceiveAndSomebodyDoes) {
  for_graphs([](const Graph& graph, std::mt19937& random) {
    const auto n = static_cast<std::uint32_t>(graph.size());
    const auto receiving = receivers(graph, draw(n, random), std::vector<bool>(n, true));
    EXPECT_NE(std::count(receiving.begin(), receiving.end(), true), 0);
    for (std::uint32_t s = 0; s < n; ++s)
      for (const SubdomainId other : graph[s]) EXPECT_FALSE(receiving[s] && receiving[other.value]);
  });
}

TEST_P(OnRandomGraphs, RepeatedAmongTheRestTheSetIsMaximal) {
  for_graphs([](const Graph& graph, std::mt19937& random) {
    const auto n = static_cast<std::uint32_t>(graph.size());
    const auto priorities = draw(n, random);
    std::vector<bool> open(n, true), chosen(n, false);
    while (std::count(open.begin(), open.end(), true) > 0) {
      const auto receiving = receivers(graph, priorities, open);
      ASSERT_NE(std::count(receiving.begin(), receiving.end(), true), 0);
      for (std::uint32_t s = 0; s < n; ++s) {
        if (!receiving[s]) continue;
        chosen[s] = true;
        open[s] = false;
        for (const SubdomainId other : graph[s]) open[other.value] = false;
      }
    }
    for (std::uint32_t s = 0; s < n; ++s) {
      const auto near =
          std::count_if(graph[s].begin(), graph[s].end(), [&](SubdomainId o) { return chosen[o.value]; });
      EXPECT_EQ(chosen[s], near == 0);
    }
  });
}

TEST_P(OnRandomGraphs, EverybodyReceivesInAsManyRoundsAsSubdomainsWhenReceiversStepBack) {
  for_graphs([](const Graph& graph, std::mt19937&) {
    const auto n = static_cast<std::uint32_t>(graph.size());
    std::vector<Priority> priorities(n);
    std::vector<bool> received(n, false);
    for (std::uint32_t s = 0; s < n; ++s) priorities[s] = {0, SubdomainId(s)};
    for (std::uint32_t round = 0; round < n; ++round) {
      const auto receiving = receivers(graph, priorities, std::vector<bool>(n, true));
      for (std::uint32_t s = 0; s < n; ++s) {
        if (receiving[s]) received[s] = true;
        priorities[s].value = receiving[s] ? 0 : priorities[s].value + 1;
      }
    }
    EXPECT_EQ(std::count(received.begin(), received.end(), false), 0);
  });
}

TEST_P(OnRandomGraphs, EverybodyReceivesWithRandomPriorities) {
  for_graphs([](const Graph& graph, std::mt19937& random) {
    const auto n = static_cast<std::uint32_t>(graph.size());
    std::vector<bool> waiting(n, true);
    // Each round half of the edges' ends or more are expected to leave (Luby): 64 rounds for 80 subdomains
    // among those that wait is beyond all chance.
    for (int round = 0; round < 64; ++round) {
      const auto receiving = receivers(graph, draw(n, random), waiting);
      for (std::uint32_t s = 0; s < n; ++s)
        if (receiving[s]) waiting[s] = false;
    }
    EXPECT_LE(std::count(waiting.begin(), waiting.end(), true), std::max(0, static_cast<int>(n) - 64));
  });
}

/// What Choice goes by: a vertex that several subdomains hold has one receiver, whoever of them is asked.
/// Takes n^4 steps where all n touch each other.
TEST_P(OnRandomGraphs, HoldersOfAVertexAgreeOnWhoReceives) {
  for_graphs_up_to(30, [](const Graph& graph, std::mt19937& random) {
    const auto n = static_cast<std::uint32_t>(graph.size());
    const auto priorities = draw(n, random);
    std::vector<ReceiverOrder> orders;
    for (std::uint32_t s = 0; s < n; ++s) {
      std::vector<Priority> neighbours;
      std::vector<SubdomainId> ids = graph[s];
      std::sort(ids.begin(), ids.end());
      for (const SubdomainId other : ids) neighbours.push_back(priorities[other.value]);
      orders.emplace_back(priorities[s], neighbours);
    }
    for (std::uint32_t s = 0; s < n; ++s)
      for (const SubdomainId other : graph[s]) {
        std::vector<SubdomainId> holders{SubdomainId(s), other};
        for (const SubdomainId third : graph[s])  // a clique: all holders of a vertex are neighbours
          if (std::ranges::all_of(holders, [&](SubdomainId h) {
                return std::ranges::find(graph[h.value], third) != graph[h.value].end();
              }))
            holders.push_back(third);
        std::vector<SubdomainId> receivers;
        for (const SubdomainId self : holders) {
          std::vector<Holder> others;
          for (const SubdomainId h : holders)
            if (h != self) others.push_back({GlobalId(), h});
          const ReceiverOrder& order = orders[self.value];
          receivers.push_back(order.subdomain(order.receiver(others)));
        }
        EXPECT_THAT(receivers, ::testing::Each(receivers.front()));
        EXPECT_THAT(holders, ::testing::Contains(receivers.front()));
      }
  });
}

INSTANTIATE_TEST_SUITE_P(Colouring, OnRandomGraphs, ::testing::Values(0.0, 0.02, 0.1, 0.5, 1.0));

TEST(Colouring, PoorTetsComeFirstAndAmongAlikeOnesTheOrderChanges) {
  const SubdomainId few(9), many(2), as_many(3);
  int changes = 0;
  for (std::uint64_t round = 0; round < 40; ++round) {
    EXPECT_LT(priority_in(round, few, 0, false), priority_in(round, many, 1, false));
    EXPECT_LT(priority_in(round, few, 3, false), priority_in(round, many, 4, false));
    EXPECT_LT(priority_in(round, few, 1000, false), priority_in(round, many, ~std::uint64_t{0}, false));
    changes += (priority_in(round, many, 40, false) < priority_in(round, as_many, 60, false)) !=
               (priority_in(round + 1, many, 40, false) < priority_in(round + 1, as_many, 60, false));
  }
  EXPECT_GT(changes, 8);
}

TEST(Colouring, WhoIsFullComesAfterAllWhoAreNot) {
  const SubdomainId full(2), other(9);
  int changes = 0;
  for (std::uint64_t round = 0; round < 40; ++round) {
    EXPECT_LT(priority_in(round, full, ~std::uint64_t{0}, true), priority_in(round, other, 0, false));
    changes += (priority_in(round, full, 0, true) < priority_in(round, other, 0, true)) !=
               (priority_in(round + 1, full, 0, true) < priority_in(round + 1, other, 0, true));
  }
  EXPECT_GT(changes, 8);
}

TEST(Colouring, TiesAreSettledById) {
  const auto of = [](std::uint64_t value, std::uint32_t id) { return Priority{value, SubdomainId(id)}; };
  const std::vector<Priority> neighbours{of(3, 5), of(2, 9)};
  EXPECT_TRUE(receives(of(3, 6), neighbours));
  EXPECT_FALSE(receives(of(3, 4), neighbours));
  EXPECT_TRUE(receives(of(4, 0), neighbours));
  EXPECT_TRUE(receives(of(0, 0), {}));
}

}  // namespace
}  // namespace weft::partition::colouring_test

// What a blueprint accepts, what it refuses and in which words, and how it describes itself.
#include "graph/dataflow/blueprint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace weft::graph::dataflow::blueprint_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

/// Bodies of many types; nothing runs here.
struct Shop {
  template <class Archive>
  void serialize(Archive&) {}
  double open(NodeContext&, int) { return 0; }
  double sell(NodeContext&, double) { return 0; }
  std::optional<double> count(NodeContext&, const double&) { return {}; }
  std::unique_ptr<int> wrap(NodeContext&, double) { return nullptr; }
  void ship(NodeContext&, std::unique_ptr<int>) {}
  void note(NodeContext&) {}
  std::uint64_t number(NodeContext&) { return 0; }
  void deliver(NodeContext&, std::uint64_t, std::vector<Arrival<std::vector<double>>>) {}
  void call(NodeContext&, std::uint64_t) {}
  void ring(NodeContext&, std::uint64_t) {}
};

/// The text of the logic_error that `act` throws.
template <class Act>
std::string refusal(const Act& act) {
  try {
    act();
  } catch (const std::logic_error& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(Blueprint, DescribesItself) {
  Blueprint<Shop> g("shop");
  const auto open = g.start<&Shop::open>("open");
  const auto sell = g.node<&Shop::sell>("sell");
  const auto deliver = g.event<&Shop::deliver>("deliver");
  const auto call = g.wakes<&Shop::call>(deliver, "call");
  const auto note = g.node<&Shop::note>("note");
  g.local(open, sell);
  g.remote<std::vector<double>>(sell, deliver);
  g.local(deliver, note, RoundStep::next);
  g.local(call, note);

  const GraphDescription& description = g.description();
  EXPECT_EQ(description.name, "shop");
  const auto node = [](const char* name, NodeKind kind) {
    return AllOf(Field(&NodeDescription::name, name), Field(&NodeDescription::kind, kind));
  };
  EXPECT_THAT(description.nodes, ElementsAre(node("open", NodeKind::start), node("sell", NodeKind::interior),
                                             node("deliver", NodeKind::event), node("call", NodeKind::wake),
                                             node("note", NodeKind::interior)));
  const auto edge = [](const char* name, EdgeKind kind, NodeIndex from, NodeIndex to, const char* type) {
    return AllOf(Field(&EdgeDescription::name, name), Field(&EdgeDescription::kind, kind),
                 Field(&EdgeDescription::from, from), Field(&EdgeDescription::to, to),
                 Field(&EdgeDescription::value_type, HasSubstr(type)));
  };
  EXPECT_THAT(description.edges,
              ElementsAre(edge("deliver -> call", EdgeKind::wake, 2, 3, "round"),
                          edge("open -> sell", EdgeKind::local, 0, 1, "double"),
                          edge("sell -> deliver", EdgeKind::remote, 1, 2, "std::vector<double"),
                          edge("deliver -> note", EdgeKind::local, 2, 4, "Nothing"),
                          edge("call -> note", EdgeKind::local, 3, 4, "Nothing")));
  EXPECT_EQ(description.edges[3].step, RoundStep::next);
  EXPECT_EQ(description.edges[4].step, RoundStep::same);
}

TEST(Blueprint, RefusesNodesOfOneNameOrBody) {
  Blueprint<Shop> g("shop");
  g.node<&Shop::sell>("sell");
  EXPECT_EQ(refusal([&] { g.node<&Shop::count>("sell"); }), "graph shop: there are two nodes sell");
  EXPECT_EQ(refusal([&] { g.node<&Shop::sell>("sell more"); }),
            "graph shop: the nodes sell and sell more have the same body");
}

TEST(Blueprint, RefusesAnEdgeTwice) {
  Blueprint<Shop> g("shop");
  const auto sell = g.node<&Shop::sell>("sell");
  const auto count = g.node<&Shop::count>("count");
  const auto deliver = g.event<&Shop::deliver>("deliver");
  g.local(sell, count);
  g.remote<std::vector<double>>(sell, deliver);
  EXPECT_EQ(refusal([&] { g.local(sell, count); }),
            "graph shop: the local edge sell -> count is declared twice");
  EXPECT_EQ(refusal([&] { g.remote<std::vector<double>>(sell, deliver); }),
            "graph shop: the remote edge sell -> deliver is declared twice");
}

TEST(Blueprint, RefusesCirclesOfLocalEdges) {
  Blueprint<Shop> g("shop");
  const auto sell = g.node<&Shop::sell>("sell");
  const auto count = g.node<&Shop::count>("count");
  g.local(sell, count);
  EXPECT_EQ(refusal([&] { g.local(count, sell, RoundStep::next); }),
            "graph shop: the local edge count -> sell closes a circle of local edges");
  EXPECT_EQ(refusal([&] { g.local(count, count); }),
            "graph shop: the local edge count -> count closes a circle of local edges");
}

TEST(Blueprint, AllowsCirclesWithRemoteEdges) {
  Blueprint<Shop> g("shop");
  const auto deliver = g.event<&Shop::deliver>("deliver");
  const auto note = g.node<&Shop::note>("note");
  g.local(deliver, note);
  g.remote<std::vector<double>>(note, deliver);
  g.remote<std::vector<double>>(deliver, deliver);
  EXPECT_EQ(g.description().edges.size(), 3u);
}

TEST(Blueprint, RefusesToCopyWhatCannotBeCopied) {
  Blueprint<Shop> g("shop");
  const auto wrap = g.node<&Shop::wrap>("wrap");
  g.local(wrap, g.node<&Shop::ship>("ship"));
  EXPECT_EQ(refusal([&] { g.local(wrap, g.node<&Shop::note>("note")); }),
            "graph shop: the local edge wrap -> note is the second from wrap, whose value cannot be copied");
}

TEST(Blueprint, RefusesTwoNodesThatOneEventWakes) {
  Blueprint<Shop> g("shop");
  const auto deliver = g.event<&Shop::deliver>("deliver");
  g.wakes<&Shop::call>(deliver, "call");
  EXPECT_EQ(refusal([&] { g.wakes<&Shop::ring>(deliver, "ring"); }),
            "graph shop: the event deliver wakes two nodes, call and ring");
}

TEST(Blueprint, RefusesToRunAWakeByALocalEdge) {
  Blueprint<Shop> g("shop");
  const auto call = g.wakes<&Shop::call>(g.event<&Shop::deliver>("deliver"), "call");
  const auto number = g.node<&Shop::number>("number");
  EXPECT_EQ(refusal([&] { g.local(number, call); }),
            "graph shop: the local edge number -> call ends at a node that only an arrival may run");
}

TEST(Blueprint, RefusesEdgesOfAnotherGraph) {
  Blueprint<Shop> larger("larger");
  larger.node<&Shop::sell>("sell");
  const auto count = larger.node<&Shop::count>("count");
  Blueprint<Shop> g("shop");
  const auto sell = g.node<&Shop::sell>("sell");
  EXPECT_EQ(refusal([&] { g.local(sell, count); }), "graph shop: an edge joins nodes of another graph");
}

}  // namespace
}  // namespace weft::graph::dataflow::blueprint_test

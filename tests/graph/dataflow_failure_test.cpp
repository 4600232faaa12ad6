// What goes wrong in a node ends the run on all ranks, and names graph, node, instance and round.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <stdexcept>

#include "graph/dataflow/blueprint.h"
#include "tests/support/ranks.h"

namespace weft::graph::dataflow::dataflow_failure_test {
namespace {

using engine::Context;
using engine::Registry;
using engine::Runtime;
using engine::Transport;
using ::testing::HasSubstr;
using weft::testing::on_ranks;

/// Does everything wrong, one thing a node.
struct Culprit {
  static inline std::atomic<int> ran_after_failure{0};  ///< a failed runtime shows no states

  template <class Archive>
  void serialize(Archive&) {}
  void blow_up(NodeContext&, int depth) {
    if (depth == 0) throw std::runtime_error("the powder was dry");
  }
  int deeper(NodeContext&, int depth) { return depth - 1; }
  void after(NodeContext&) { ++ran_after_failure; }
  void throw_oddly(NodeContext&) { throw 5; }
  void send_without_edge(NodeContext& context, Ref<Culprit> to) {
    context.send<&Culprit::receive>(to, 1, 2.5);
  }
  void send(NodeContext& context, Ref<Culprit> to) {
    context.send<&Culprit::receive>(to, context.round(), 2.5);
  }
  void expect_twice(NodeContext& context) {
    context.expect<&Culprit::receive>(4, {{context.self()}});
    context.expect<&Culprit::receive>(4, {{context.self()}});
  }
  void expect_nothing_twice(NodeContext& context) {
    context.expect<&Culprit::receive>(4, {});
    context.expect<&Culprit::receive>(4, {});
  }
  void expect_itself(NodeContext& context) {
    context.expect<&Culprit::receive>(context.round(), {{context.self()}});
  }
  void expect_and_send_twice(NodeContext& context) {
    expect_itself(context);
    for (int i = 0; i < 2; ++i) send(context, {context.self()});
  }
  void receive(NodeContext&, std::uint64_t, std::vector<Arrival<double>> values) {
    if (!values.empty()) throw std::runtime_error("no, thank you");
  }

  static Blueprint<Culprit> blueprint() {
    Blueprint<Culprit> g("culprit");
    const auto deeper = g.start<&Culprit::deeper>("deeper");
    const auto blow_up = g.node<&Culprit::blow_up>("blow up");
    g.local(deeper, blow_up);
    g.local(deeper, g.node<&Culprit::after>("after"));
    g.start<&Culprit::throw_oddly>("throw oddly");
    g.start<&Culprit::send_without_edge>("send without edge");
    const auto send = g.start<&Culprit::send>("send");
    g.start<&Culprit::expect_twice>("expect twice");
    g.start<&Culprit::expect_nothing_twice>("expect nothing twice");
    g.start<&Culprit::expect_itself>("expect itself");
    const auto receive = g.event<&Culprit::receive>("receive");
    g.remote<double>(send, receive);
    g.remote<double>(g.start<&Culprit::expect_and_send_twice>("expect and send twice"), receive);
    return g;
  }
};

class DataflowFailureOnRanks : public weft::testing::OnRanks {
 protected:
  Ref<Culprit> culprit() const { return {{engine::Rank(GetParam() - 1), 1}}; }
  std::string id() const { return std::to_string(GetParam() - 1) + ".1"; }

  /// `act` on rank 0, in a run in which every rank has a culprit, fails it everywhere with `message`.
  void expect_failure(const std::function<void(Context&)>& act, const std::string& message) {
    on_ranks(GetParam(), [&](Transport& transport) {
      Registry registry;
      register_blueprint<Culprit>(registry);
      Runtime runtime(transport, registry,
                      {.balancer = engine::no_balancing(), .on_failure = [](const std::string&) {}});
      runtime.run([](Context& context) { create<Culprit>(context); });
      std::optional<std::string> failure;
      try {
        runtime.run([&](Context& context) {
          if (context.rank() == engine::Rank(0)) act(context);
        });
      } catch (const engine::RunFailure& caught) {
        failure = caught.what();
      }
      ASSERT_TRUE(failure) << "no failure on rank " << transport.rank().value;
      EXPECT_THAT(*failure, HasSubstr(message));
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Ranks, DataflowFailureOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

TEST_P(DataflowFailureOnRanks, ABodyThatThrowsIsNamedAndNothingRunsAfterIt) {
  expect_failure([&](Context& context) { start<&Culprit::deeper>(context, culprit(), 9, 1); },
                 "node blow up of graph culprit, instance " + id() + ", round 9: the powder was dry");
  EXPECT_EQ(Culprit::ran_after_failure, 0);
}

TEST_P(DataflowFailureOnRanks, AnExceptionOfAnyTypeIsNamed) {
  expect_failure(
      [&](Context& context) { start<&Culprit::throw_oddly>(context, culprit()); },
      "node throw oddly of graph culprit, instance " + id() + ", round 0: an exception of unknown type");
}

TEST_P(DataflowFailureOnRanks, AnEventThatThrowsIsNamed) {
  expect_failure(
      [&](Context& context) {
        start<&Culprit::expect_itself>(context, culprit(), 2);
        start<&Culprit::send>(context, culprit(), 2, culprit());
      },
      "node receive of graph culprit, instance " + id() + ", round 2: no, thank you");
}

TEST_P(DataflowFailureOnRanks, SendingAlongAnUndeclaredEdgeIsRefused) {
  expect_failure(
      [&](Context& context) { start<&Culprit::send_without_edge>(context, culprit(), 0, culprit()); },
      "graph culprit: the node send without edge sends to the event receive, but no remote edge send without "
      "edge -> receive is declared");
}

TEST_P(DataflowFailureOnRanks, DeclaringAnEventTwiceIsRefused) {
  expect_failure([&](Context& context) { start<&Culprit::expect_twice>(context, culprit()); },
                 "graph culprit: event receive: the event waits already in round 4");
  expect_failure([&](Context& context) { start<&Culprit::expect_nothing_twice>(context, culprit()); },
                 "graph culprit: event receive: it is declared again before it has run in round 4");
}

TEST_P(DataflowFailureOnRanks, AStrangersValueIsRefused) {
  expect_failure(
      [&](Context& context) {
        const auto stranger = create<Culprit>(context);
        start<&Culprit::send>(context, stranger, 2, culprit());
        start<&Culprit::expect_itself>(context, culprit(), 2);
      },
      "no dependency of it");
}

TEST_P(DataflowFailureOnRanks, ASecondValueInARoundIsRefused) {
  expect_failure(
      [&](Context& context) {
        for (int i = 0; i < 2; ++i) start<&Culprit::send>(context, culprit(), 2, culprit());
      },
      "graph culprit: event receive: object " + id() + " signals round 2 twice");
}

TEST_P(DataflowFailureOnRanks, ASecondValueThatComesBeforeTheEventRunsIsRefused) {
  expect_failure(
      [&](Context& context) { start<&Culprit::expect_and_send_twice>(context, culprit(), 2); },
      "graph culprit: event receive: object " + id() + " signals round 2 though all its values have come");
}

}  // namespace
}  // namespace weft::graph::dataflow::dataflow_failure_test

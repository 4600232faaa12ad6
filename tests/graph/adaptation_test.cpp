// The whole distributed method on all numbers of ranks: the same bytes everywhere, and sound whatever
// happens.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <sstream>
#include <thread>

#include "engine/network/loopback_transport.h"
#include "engine/simulate/simulation.h"
#include "graph/adaptation/distributed_adaptation.h"
#include "meshing/mesh/check_mesh.h"
#include "partition/communication/reduce.h"
#include "partition/output/measure_pieces.h"
#include "partition/output/numbering.h"
#include "partition/verify/check_subdomains.h"
#include "tests/partition/distribute/slices.h"
#include "tests/partition/scenes.h"
#include "tests/support/ranks.h"
#include "tests/support/repetitions.h"
#include "tests/support/turning_metric.h"

namespace weft::graph::adaptation::adaptation_test {
namespace {

using namespace weft::support;
using engine::Registry;
using engine::Runtime;
using engine::Transport;
using partition::MeshPiece;
using partition::SubdomainId;
using ::testing::ElementsAre;
using weft::testing::kSlowness;
using weft::testing::on_ranks;

class AdaptationOnRanks : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, AdaptationOnRanks, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

struct Setting {
  std::uint32_t subdomains = 5;
  std::string partitioner = "graph";
  int threads = 1;
  engine::BalancerFactory balancer = engine::work_stealing();
  std::chrono::microseconds delay{0};
  std::atomic<bool>* interrupt = nullptr;
  ProgressBoard* news = nullptr;
  std::uint32_t most_shifts = 12;
  double tets_of_seed = 1e5;
  bool check = false;
  std::function<void(partition::Subdomain&)> on_check = {};
  std::function<void(Runtime&)> on_start = {}, on_end = {};  ///< of the loop
};

MetricMesh metric_mesh(MeshData mesh, double size, unsigned seed = 1) {
  shuffle(mesh, seed);
  meshing::LogMetricField log_metrics = wanted_sizes(mesh, size, seed);
  return {std::move(mesh), std::move(log_metrics)};
}

partition::ExpectedTotals totals_of(const MeshData& mesh) {
  const meshing::CheckReport report = check_mesh(mesh);
  return {report.volume, report.area_by_ref};
}

/// What one rank has after a run.
struct RankOutcome {
  Runtime& runtime;
  EnginePeers& peers;
  DistributedResult& result;
  const AdaptationPlan& plan;
};

void adapt_on_rank(Transport& network, const MetricMesh& whole, const Setting& setting,
                   const std::function<void(RankOutcome)>& look) {
  const auto late = setting.delay.count() > 0 ? weft::testing::delayed(network, setting.delay, 5) : nullptr;
  Registry registry;
  register_adaptation(registry);
  RankData rank;
  Runtime runtime(late ? *late : network, registry,
                  {.threads = setting.threads, .balancer = setting.balancer, .local = &rank});
  EnginePeers peers(runtime);
  DistributedOptions options;
  options.decomposition.num_subdomains = setting.subdomains;
  options.decomposition.partitioner = partition::parse_partitioner(setting.partitioner, setting.subdomains);
  options.shift = {2, false};
  options.hausd = 0.002;
  options.threads = setting.threads;
  options.interrupt = setting.interrupt;
  options.news = setting.news;
  options.most_shifts = setting.most_shifts;
  options.tets_of_seed = setting.tets_of_seed;
  options.check = setting.check;
  options.on_check = setting.on_check;
  if (setting.on_start) options.on_start = [&] { setting.on_start(runtime); };
  if (setting.on_end) options.on_end = [&] { setting.on_end(runtime); };
  DistributedResult result =
      adapt_distributed(runtime, peers, rank, slice_of(whole, peers.rank(), peers.ranks()), options);
  look({runtime, peers, result, rank.plan});
}

template <class T>
void append(partition::Bytes& bytes, const std::vector<T>& values) {
  static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, meshing::Point> ||
                std::is_same_v<T, meshing::LogMetric>);  // no padding
  const std::uint64_t size = values.size();
  const auto begin = bytes.size();
  bytes.resize(begin + sizeof(size) + size * sizeof(T));
  std::memcpy(bytes.data() + begin, &size, sizeof(size));
  if (size > 0) std::memcpy(bytes.data() + begin + sizeof(size), values.data(), size * sizeof(T));
}

partition::Bytes bytes_of(const MeshPiece& p) {
  partition::Bytes bytes;
  const MeshData& m = p.mesh;
  append(bytes, m.points), append(bytes, m.point_refs), append(bytes, m.tets), append(bytes, m.tet_refs);
  append(bytes, m.triangles), append(bytes, m.triangle_refs), append(bytes, m.edges),
      append(bytes, m.edge_refs);
  append(bytes, m.corners), append(bytes, m.required_points), append(bytes, m.ridges);
  append(bytes, m.required_edges), append(bytes, m.required_triangles);
  append(bytes, p.log_metrics), append(bytes, p.ids), append(bytes, p.shared);
  return bytes;
}

using PieceBytes = std::map<SubdomainId, partition::Bytes>;

/// All ranks: the pieces of all of them on rank 0.
PieceBytes gather_bytes(partition::Peers& peers, const std::vector<MeshPiece>& mine) {
  PieceBytes all;
  std::uint64_t most = 0;
  for (const auto& n : partition::allgather(peers, std::vector<std::uint64_t>{mine.size()}))
    most = std::max(most, n[0]);
  for (std::uint64_t i = 0; i < most; ++i) {
    std::vector<partition::Bytes> to_each(static_cast<std::size_t>(peers.ranks()));
    if (i < mine.size()) {
      append(to_each[0], std::vector<SubdomainId>{mine[i].subdomain});
      const partition::Bytes piece = bytes_of(mine[i]);
      to_each[0].insert(to_each[0].end(), piece.begin(), piece.end());
    }
    for (const partition::Bytes& arrived : peers.all_to_all(std::move(to_each))) {
      if (arrived.empty()) continue;
      SubdomainId id;
      std::memcpy(&id, arrived.data() + sizeof(std::uint64_t), sizeof(id));
      EXPECT_TRUE(all.emplace(id, arrived).second) << "two pieces of subdomain " << id;
    }
  }
  return all;
}

/// The same on one rank of its own, whatever the test runs on; nothing but in the first process, which
/// compares.
PieceBytes on_one_rank(const MetricMesh& whole, const Setting& setting) {
  if (!weft::testing::is_first_process()) return {};
  engine::LoopbackNetwork network(1);
  PieceBytes pieces;
  adapt_on_rank(network.transport(engine::Rank(0)), whole, setting,
                [&](RankOutcome rank) { pieces = gather_bytes(rank.peers, rank.result.pieces); });
  return pieces;
}

/// Every invariant of the result, on all ranks.
void expect_sound(RankOutcome rank, const MetricMesh& whole, const Setting& setting) {
  const auto report = check_pieces(rank.peers, rank.result.pieces, totals_of(whole.mesh));
  EXPECT_THAT(report.problems, ElementsAre());
  std::uint64_t pieces = 0;
  for (const auto& n :
       partition::allgather(rank.peers, std::vector<std::uint64_t>{rank.result.pieces.size()}))
    pieces += n[0];
  EXPECT_EQ(pieces, setting.subdomains);
  ASSERT_EQ(rank.result.was_interface.size(), rank.result.pieces.size());
  ASSERT_EQ(rank.result.shifts.size(), rank.result.pieces.size());
  for (std::size_t p = 0; p < rank.result.pieces.size(); ++p) {
    EXPECT_EQ(rank.result.was_interface[p].size(), rank.result.pieces[p].mesh.points.size());
    for (const auto& shared : rank.result.pieces[p].shared)
      EXPECT_TRUE(rank.result.was_interface[p][shared.vertex]);
  }
}

void expect_on_ranks(int ranks, const MetricMesh& whole, const Setting& setting, const PieceBytes& expected) {
  on_ranks(ranks, [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      expect_sound(rank, whole, setting);
      const PieceBytes all = gather_bytes(rank.peers, rank.result.pieces);
      EXPECT_TRUE(rank.peers.rank() > 0 || all == expected);
    });
  });
}

void expect_same_as_on_one_rank(int ranks, const MetricMesh& whole, const Setting& setting) {
  const PieceBytes expected = on_one_rank(whole, setting);
  EXPECT_TRUE(expected.size() == setting.subdomains || !weft::testing::is_first_process());
  expect_on_ranks(ranks, whole, setting, expected);
}

/// On simulated ranks, in this thread.
void expect_on_simulated_ranks(int ranks, const MetricMesh& whole, const Setting& setting,
                               const PieceBytes& expected) {
  PieceBytes pieces;
  engine::SimulationOptions options;
  options.ranks = ranks;
  engine::simulate(options, [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      expect_sound(rank, whole, setting);
      PieceBytes all = gather_bytes(rank.peers, rank.result.pieces);
      if (rank.peers.rank() == 0) pieces = std::move(all);
    });
  });
  EXPECT_TRUE(pieces == expected) << "on " << ranks << " simulated ranks";
}

/// The most that any rank has sent, and the most others it has had messages with: before the loop, in it and
/// after it.
using MostExchanged = std::array<engine::Exchanged, 3>;

/// A subdomain of about as many tets for every rank.
MostExchanged most_exchanged(int ranks) {
  const int cells = static_cast<int>(std::lround(2 * std::cbrt(ranks)));
  const MetricMesh whole = metric_mesh(unit_cube(cells), 1.0 / cells);
  Setting setting;
  setting.subdomains = static_cast<std::uint32_t>(ranks);
  std::vector<std::array<engine::RankSummary, 2>> marks(static_cast<std::size_t>(ranks));
  setting.on_start = [&](const Runtime& runtime) { marks[runtime.rank().index()][0] = runtime.summary(); };
  setting.on_end = [&](const Runtime& runtime) { marks[runtime.rank().index()][1] = runtime.summary(); };
  MostExchanged most{};
  engine::simulate({.ranks = ranks}, [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      measure_pieces(rank.peers, rank.result.pieces);
      number_pieces(rank.peers, rank.result.pieces);
      const auto& [start, end] = marks[network.rank().index()];
      const std::array parts = {engine::exchanged_between({}, start), engine::exchanged_between(start, end),
                                engine::exchanged_between(end, rank.runtime.summary())};
      for (std::size_t i = 0; i < parts.size(); ++i) {
        most[i].messages = std::max(most[i].messages, parts[i].messages);
        most[i].peers = std::max(most[i].peers, parts[i].peers);
      }
    });
  });
  return most;
}

/// WEFT_SIMULATED_RANKS="64 1024" prints how it is there too: the table in graph/README.md.
TEST(SimulatedAdaptation, BeforeAndAfterTheLoopMessagesGoWithTheLogarithmOfTheRanks) {
  const int few = 16, many = kSlowness > 1 ? 32 : 64;
  const MostExchanged of_few = most_exchanged(few), of_many = most_exchanged(many);
  const double steps = std::log2(many) / std::log2(few);
  for (const std::size_t part : {0u, 2u}) {
    EXPECT_LE(static_cast<double>(of_many[part].messages),
              1.2 * steps * static_cast<double>(of_few[part].messages));
    EXPECT_LE(static_cast<double>(of_many[part].peers), 3 + 2 * std::log2(many));
  }
  std::istringstream more(std::getenv("WEFT_SIMULATED_RANKS") ? std::getenv("WEFT_SIMULATED_RANKS") : "");
  for (int ranks = 0; more >> ranks;) {
    const MostExchanged most = most_exchanged(ranks);
    std::printf("| %d |", ranks);
    for (const engine::Exchanged& e : most)
      std::printf(" %llu to %llu |", static_cast<unsigned long long>(e.messages),
                  static_cast<unsigned long long>(e.peers));
    std::printf("\n");
  }
}

TEST(SimulatedAdaptation, ThePiecesAreThoseOfOneRankUnderBothBalancers) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.25);
  Setting setting;
  setting.subdomains = 24;
  const PieceBytes expected = on_one_rank(whole, setting);
  for (const auto& balancer : {engine::work_stealing(), engine::diffusion()}) {
    setting.balancer = balancer;
    for (const int ranks : {3, kSlowness > 1 ? 8 : 64})
      expect_on_simulated_ranks(ranks, whole, setting, expected);
  }
}

TEST_P(AdaptationOnRanks, ThePiecesDoNotDependOnRanksAndBalancer) {
  const MetricMesh whole = metric_mesh(layered_box(3, 2, 3), 0.3);
  Setting setting;
  const PieceBytes expected = on_one_rank(whole, setting);
  for (const auto& balancer : {engine::work_stealing(), engine::no_balancing(), engine::rotate()}) {
    setting.balancer = balancer;
    expect_on_ranks(GetParam(), whole, setting, expected);
  }
}

TEST_P(AdaptationOnRanks, NorOnTheNetwork) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.25);
  Setting setting;
  setting.subdomains = 12;
  setting.partitioner = "pqr:3x2x2";
  setting.balancer = engine::rotate();
  setting.delay = std::chrono::microseconds(700);
  expect_same_as_on_one_rank(GetParam(), whole, setting);
}

TEST_P(AdaptationOnRanks, SlabsAlongTheBoundary) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.2);
  for (const char* partitioner : {"pqr:4x1x1:harmonic=3,4", "pqr:2x2x1:wall=5,2"})
    for (const double tets_of_seed : {1e5, 50.}) {  // a division of one mesh, and of the input at once
      SCOPED_TRACE(partitioner);
      Setting setting;
      setting.subdomains = 4;
      setting.partitioner = partitioner;
      setting.tets_of_seed = tets_of_seed;
      expect_same_as_on_one_rank(GetParam(), whole, setting);
    }
}

TEST_P(AdaptationOnRanks, AnyNumberOfSubdomains) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.3);
  for (const std::uint32_t subdomains : {1u, 2u, 16u, 100u, 500u}) {  // there are 384 tets
    if (subdomains > repetitions(kSlowness > 1 ? 50 : 100, 500)) continue;
    SCOPED_TRACE(subdomains);
    Setting setting;
    setting.subdomains = subdomains;
    expect_same_as_on_one_rank(GetParam(), whole, setting);
  }
}

TEST_P(AdaptationOnRanks, MoreSubdomainsThanTets) {
  const MetricMesh whole = metric_mesh(two_tets(), 0.4);
  Setting setting;
  setting.subdomains = 9;
  expect_same_as_on_one_rank(GetParam(), whole, setting);
}

TEST_P(AdaptationOnRanks, SubdomainsMayFallApart) {
  const MetricMesh whole = metric_mesh(two_bodies(3), 0.3);
  for (const char* partitioner : {"bisection", "pqr:1x1x4"}) {
    SCOPED_TRACE(partitioner);
    Setting setting;
    setting.subdomains = 4;
    setting.partitioner = partitioner;
    expect_same_as_on_one_rank(GetParam(), whole, setting);
  }
}

TEST_P(AdaptationOnRanks, SeveralThreadsARank) {
  const MetricMesh whole = metric_mesh(layered_box(3, 2, 3), 0.25);
  for (const std::uint32_t subdomains : {1u, 7u}) {
    Setting setting;
    setting.threads = 2;
    setting.subdomains = subdomains;
    on_ranks(GetParam(), [&](Transport& network) {
      adapt_on_rank(network, whole, setting, [&](RankOutcome rank) { expect_sound(rank, whole, setting); });
    });
  }
}

TEST_P(AdaptationOnRanks, TheLoopCallsNothingCollective) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.3);
  Setting setting;
  setting.subdomains = 8;
  on_ranks(GetParam(), [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      for (const engine::RankSummary& summary : rank.runtime.gather_summaries())
        EXPECT_EQ(summary.collective_calls, 0) << "on rank " << summary.rank.value;
    });
  });
}

/// Raises a flag after so many handlers of a rank; else leaves all objects where they are.
class Interrupter final : public engine::Balancer {
 public:
  Interrupter(std::atomic<bool>& flag, std::size_t after) : flag_(flag), left_(after) {}
  void step(engine::BalanceActions&, engine::TimePoint) override {}
  void told(engine::Rank, const engine::BalanceMessage&, engine::BalanceActions&) override {}
  void finished(const std::vector<engine::ObjectId>& ids, engine::BalanceActions&) override {
    left_ -= std::min(left_, ids.size());
    if (left_ == 0) flag_ = true;
  }
  bool wants_finished() const override { return true; }

 private:
  std::atomic<bool>& flag_;
  std::size_t left_;
};

TEST_P(AdaptationOnRanks, AnInterruptLeavesAConformingMesh) {
  const MetricMesh whole = metric_mesh(layered_box(3, 2, 3), 0.25);
  for (const std::size_t after : {0u, 10u, 60u, 100u}) {
    SCOPED_TRACE(after);
    std::atomic<bool> flag{after == 0};
    Setting setting;
    setting.subdomains = 10;
    setting.interrupt = &flag;
    setting.balancer = [&](engine::Rank, int) { return std::make_unique<Interrupter>(flag, after); };
    on_ranks(GetParam(), [&](Transport& network) {
      adapt_on_rank(network, whole, setting, [&](RankOutcome rank) { expect_sound(rank, whole, setting); });
    });
  }
}

/// Going on would leave a few hundred tets.
TEST(Adaptation, OfARunThatFailsIsGivenUp) {
  if (weft::testing::is_distributed()) GTEST_SKIP() << "for one process";
  const MetricMesh whole = metric_mesh(unit_cube(20), 0.5);
  ProgressBoard board;
  std::thread stopper;
  Setting setting;
  setting.subdomains = 1;
  setting.news = &board;
  setting.on_start = [&](Runtime& runtime) {
    stopper = std::thread([&] {
      while (!board.take()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      runtime.request_stop("enough");
    });
  };
  engine::LoopbackNetwork network(1);
  EXPECT_THROW(adapt_on_rank(network.transport(engine::Rank(0)), whole, setting, [](RankOutcome) {}),
               engine::RunFailure);
  stopper.join();
  const std::optional<ProgressSums> last = board.take();
  ASSERT_TRUE(last);
  EXPECT_GT(last->left.tets, whole.mesh.tets.size() / 4);
}

TEST_P(AdaptationOnRanks, ABallStaysABall) {
  MetricMesh whole{ball(2, 3), {}};
  whole.log_metrics = wanted_sizes(whole.mesh, 0.25, 2);
  Setting setting;
  setting.subdomains = 6;
  on_ranks(GetParam(), [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      const auto report = check_pieces(rank.peers, rank.result.pieces);
      EXPECT_THAT(report.problems, ElementsAre());
      EXPECT_NEAR(report.volume, 4 * std::numbers::pi / 3, 0.1);
    });
  });
}

/// All of the interface has been free in the end, and the records of the shifts add up.
TEST_P(AdaptationOnRanks, ShiftsUntilNothingIsWanted) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.25);
  Setting setting;
  setting.subdomains = 6;
  on_ranks(GetParam(), [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      std::vector<ShiftRecord> mine;
      for (const auto& shifts : rank.result.shifts) mine.insert(mine.end(), shifts.begin(), shifts.end());
      std::map<std::uint64_t, ShiftRecord> rounds;
      for (const auto& part : partition::allgather(rank.peers, mine))
        for (const ShiftRecord& r : part) {
          ShiftRecord& sum = rounds[r.round];
          sum.wanted += r.wanted, sum.sent += r.sent, sum.received += r.received, sum.thawed += r.thawed;
        }
      ASSERT_GE(rounds.size(), 2u);
      EXPECT_LT(rounds.size(), DistributedOptions{}.most_shifts);  // it ended by itself
      for (const auto& [round, sum] : rounds) EXPECT_EQ(sum.sent, sum.received) << "round " << round;
      const auto first = std::ranges::find_if(rounds, [](const auto& r) { return r.second.wanted > 0; });
      ASSERT_NE(first, rounds.end());
      EXPECT_LE(first->first, 1u);  // that before it is the division
      EXPECT_GT(first->second.thawed, 0u);
      EXPECT_EQ(rounds.rbegin()->second.wanted, 0u);
    });
  });
}

/// What has been told on all ranks against the pieces that they have in the end.
void expect_all_at_rest(partition::Peers& peers, const ProgressSums& told,
                        const std::vector<MeshPiece>& pieces) {
  std::vector<std::int64_t> sums(5, 0);  // at rest, through their step, told of, tets told of, tets
  for (const ProgressSums::Step& step : told.steps) {
    sums[0] += step.at_rest;
    sums[1] += step.done;
    sums[2] += step.subdomains;
  }
  sums[3] = static_cast<std::int64_t>(told.left.tets);
  for (const MeshPiece& piece : pieces) sums[4] += static_cast<std::int64_t>(piece.mesh.tets.size());
  sums = partition::sum(peers, sums);
  const std::int64_t subdomains = Setting{}.subdomains;
  EXPECT_THAT(sums, ElementsAre(subdomains, subdomains, subdomains, sums[4], sums[4]));
}

TEST_P(AdaptationOnRanks, SubdomainsTellHowFarTheyAreAndChangeNothingByIt) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.25);
  const PieceBytes silent = on_one_rank(whole, Setting{});
  on_ranks(GetParam(), [&](Transport& network) {
    ProgressBoard board;
    Setting setting;
    setting.balancer = engine::rotate();  // so what a subdomain has told was told on several ranks
    setting.news = &board;
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      expect_all_at_rest(rank.peers, board.take().value_or(ProgressSums{}), rank.result.pieces);
      const PieceBytes all = gather_bytes(rank.peers, rank.result.pieces);
      EXPECT_TRUE(rank.peers.rank() > 0 || all == silent);
    });
  });
}

// --- Several phases

/// Tets of one shape and a metric that wants quite others.
MetricMesh far_from_its_metric(std::uint32_t cells, double complexity) {
  MetricMesh whole{unit_cube(cells), {}};
  shuffle(whole.mesh, 1);
  whole.log_metrics = meshing::sample(meshing::AnalyticMetric("polar-2"), whole.mesh);
  meshing::scale_to_complexity(whole.mesh, complexity, whole.log_metrics);
  return whole;
}

/// Tets that are good as they are, but for those longer than wanted.
MetricMesh near_its_metric(std::uint32_t cells) {
  MetricMesh whole{unit_cube(cells), {}};
  const double l = 2 * std::log(cells);
  whole.log_metrics.assign(whole.mesh.points.size(), {l, 0, l, 0, 0, l});
  return whole;
}

/// The plan that a run has made for this many subdomains.
AdaptationPlan plan_for(const MetricMesh& whole, std::uint32_t subdomains) {
  Setting setting;
  setting.subdomains = subdomains;
  AdaptationPlan plan;
  engine::LoopbackNetwork network(1);
  std::atomic<bool> at_once{true};
  setting.interrupt = &at_once;
  adapt_on_rank(network.transport(engine::Rank(0)), whole, setting,
                [&](RankOutcome rank) { plan = rank.plan; });
  return plan;
}

std::vector<double> coarseness_of_phases(const MetricMesh& whole, std::uint32_t subdomains) {
  std::vector<double> all;
  for (const Phase& phase : plan_for(whole, subdomains).phases) all.push_back(phase.coarseness);
  return all;
}

TEST_P(AdaptationOnRanks, PhasesGiveTheSameEverywhere) {
  const MetricMesh whole = far_from_its_metric(7, 700);
  for (const std::uint32_t subdomains : {2u, 10u}) {
    SCOPED_TRACE(subdomains);
    EXPECT_GT(coarseness_of_phases(whole, subdomains).size(), 1u);
    Setting setting;
    setting.subdomains = subdomains;
    setting.balancer = engine::rotate();
    setting.delay = std::chrono::microseconds(300);
    expect_same_as_on_one_rank(GetParam(), whole, setting);
  }
}

TEST_P(AdaptationOnRanks, AnInterruptOfAnyPhaseLeavesAConformingMesh) {
  const MetricMesh whole = far_from_its_metric(8, 1000);
  for (const std::size_t after : {0u, 5u, 25u, 60u, 100u}) {
    SCOPED_TRACE(after);
    std::atomic<bool> flag{after == 0};
    Setting setting;
    setting.interrupt = &flag;
    setting.balancer = [&](engine::Rank, int) { return std::make_unique<Interrupter>(flag, after); };
    on_ranks(GetParam(), [&](Transport& network) {
      adapt_on_rank(network, whole, setting, [&](RankOutcome rank) { expect_sound(rank, whole, setting); });
    });
  }
}

TEST(Phases, AreSeveralWhereTheInputIsFarFromItsMetric) {
  const MetricMesh far = far_from_its_metric(10, 3000);
  EXPECT_THAT(coarseness_of_phases(far, 4), ElementsAre(4, 1));
  EXPECT_THAT(coarseness_of_phases(far, 30), ElementsAre(2, 1)) << "with four: sixteen tets a part";
  EXPECT_THAT(coarseness_of_phases(far, 400), ElementsAre(1)) << "with two: nine";
  EXPECT_THAT(coarseness_of_phases(far, 1), ElementsAre(1)) << "the kernel knows what to do";
  EXPECT_THAT(coarseness_of_phases(far_from_its_metric(4, 20000), 2), ElementsAre(8, 1)) << "it is coarse";
  MetricMesh near = far;
  std::ranges::fill(near.log_metrics, meshing::LogMetric{4, 0, 4, 0, 0, 4});
  EXPECT_THAT(coarseness_of_phases(near, 4), ElementsAre(1)) << "its tets are good as they are";
}

TEST(Phases, FollowEachOther) {
  AdaptationPlan plan;
  EXPECT_TRUE(plan.begins_phase(0) && !plan.begins_phase(1) && !plan.is_coarse(0));
  EXPECT_EQ(plan.shift_of(3), 3u);
  plan.phases = {{0, 4}, {2, 2}, {4, 1}};
  std::vector<std::uint64_t> shifts, begins, coarse;
  for (std::uint64_t round = 0; round < 7; ++round) {
    shifts.push_back(plan.shift_of(round));
    begins.push_back(plan.begins_phase(round));
    coarse.push_back(plan.is_coarse(round));
  }
  EXPECT_THAT(shifts, ElementsAre(0, 1, 0, 1, 0, 1, 2));
  EXPECT_THAT(begins, ElementsAre(1, 0, 1, 0, 1, 0, 0));
  EXPECT_THAT(coarse, ElementsAre(1, 1, 1, 1, 0, 0, 0));
}

/// What is divided has its share of the work. What one run gives is a matter of chance, so it is the mean of
/// several that counts.
TEST(Phases, LeaveSubdomainsOfLikeSize) {
  double sum = 0;
  std::vector<double> complexities = {3000, 4000};
  if (repetitions(0, 1)) complexities.insert(complexities.end(), {3500, 4500});
  for (const double complexity : complexities) {
    const MetricMesh whole = far_from_its_metric(12, complexity);
    Setting setting;
    setting.subdomains = 12;
    std::vector<std::size_t> tets;
    engine::LoopbackNetwork network(1);
    adapt_on_rank(network.transport(engine::Rank(0)), whole, setting, [&](RankOutcome rank) {
      EXPECT_EQ(rank.plan.phases.size(), 2u);
      for (const MeshPiece& piece : rank.result.pieces) tets.push_back(piece.mesh.tets.size());
    });
    const std::size_t all = std::accumulate(tets.begin(), tets.end(), std::size_t{0});
    const double largest =
        static_cast<double>(std::ranges::max(tets) * tets.size()) / static_cast<double>(all);
    EXPECT_LT(largest, 4) << "to " << complexity;
    sum += largest;
  }
  EXPECT_LT(sum / static_cast<double>(complexities.size()), 3.4);
}

/// As good as what the kernel makes of the whole.
TEST(Phases, GiveTheQualityOfOneMesh) {
  const MetricMesh whole = far_from_its_metric(12, 4000);
  const auto measure_parts = [&](std::uint32_t subdomains) {
    Setting setting;
    setting.subdomains = subdomains;
    engine::LoopbackNetwork network(1);
    meshing::Measures measures;
    adapt_on_rank(network.transport(engine::Rank(0)), whole, setting, [&](RankOutcome rank) {
      EXPECT_EQ(rank.plan.phases.size() > 1, subdomains > 1);
      measures = partition::measure_pieces(rank.peers, rank.result.pieces);
      expect_sound(rank, whole, setting);
    });
    return measures;
  };
  const meshing::Measures one = measure_parts(1), parts = measure_parts(6);
  EXPECT_GT(parts.quality_mean, 0.99 * one.quality_mean);
  EXPECT_GT(parts.edges_unit, 0.985 * one.edges_unit);
  EXPECT_GT(parts.quality_q01, 0.96 * one.quality_q01);
}

/// Where the metric turns within the thickness of the domain, no coarse mesh fits it, and the parts of one
/// that does not would have needles in their interfaces.
TEST(Phases, DivideNoHeapOfNeedles) {
  MetricMesh whole{thin_slab(), {}};
  whole.log_metrics = turning_metric(whole.mesh, 2000, 1);
  Setting setting;
  setting.subdomains = 4;
  engine::LoopbackNetwork network(1);
  adapt_on_rank(network.transport(engine::Rank(0)), whole, setting, [&](RankOutcome rank) {
    EXPECT_EQ(rank.plan.seeds.size(), 1u);
    const meshing::Measures measures = partition::measure_pieces(rank.peers, rank.result.pieces);
    EXPECT_GT(measures.quality_mean, 0.5);
    expect_sound(rank, whole, setting);
  });
}

// --- Division

TEST_P(AdaptationOnRanks, FewTetsBecomeManySubdomainsAlikeEverywhere) {
  const MetricMesh whole = far_from_its_metric(1, 700);  // six tets
  Setting setting;
  setting.subdomains = 9;
  for (const char* partitioner : {"graph", "pqr:3x3x1"}) {
    setting.partitioner = partitioner;
    expect_same_as_on_one_rank(GetParam(), whole, setting);
  }
}

TEST_P(AdaptationOnRanks, SoDoSubdomainsWithInterfacesWhenTheyDivide) {
  const MetricMesh whole = far_from_its_metric(8, 1000);
  Setting setting;
  setting.subdomains = 10;
  setting.tets_of_seed = 900;
  setting.balancer = engine::rotate();
  setting.delay = std::chrono::microseconds(300);
  const PieceBytes expected = on_one_rank(whole, setting);
  setting.check = true;
  on_ranks(GetParam(), [&](Transport& network) {
    adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
      EXPECT_EQ(rank.plan.seeds.size(), 3u);
      EXPECT_EQ(rank.plan.division, 2u) << "after two shifts";
      const PieceBytes all = gather_bytes(rank.peers, rank.result.pieces);
      EXPECT_TRUE(rank.peers.rank() > 0 || all == expected);
    });
  });
}

TEST(Division, GivesEveryoneALikeShare) {
  const MetricMesh whole = far_from_its_metric(1, 1500);
  Setting setting;
  setting.subdomains = 8;
  engine::LoopbackNetwork network(1);
  adapt_on_rank(network.transport(engine::Rank(0)), whole, setting, [&](RankOutcome rank) {
    EXPECT_THAT(rank.plan.seeds, ElementsAre(SubdomainId(0)));
    std::size_t largest = 0, all = 0;
    for (const MeshPiece& piece : rank.result.pieces) {
      EXPECT_GT(piece.mesh.tets.size(), 0u);
      largest = std::max(largest, piece.mesh.tets.size());
      all += piece.mesh.tets.size();
    }
    EXPECT_LT(largest, all / 3);
  });
}

TEST(Division, PartsFollowTheirSeed) {
  AdaptationPlan plan;
  plan.subdomains = 10;
  EXPECT_EQ(plan.parts_with(SubdomainId(4)).first, SubdomainId(4)) << "nobody divides";
  EXPECT_EQ(plan.parts_with(SubdomainId(4)).count, 1u);
  plan.seeds = {SubdomainId(0), SubdomainId(3), SubdomainId(9)};
  std::vector<std::uint32_t> first, count;
  for (std::uint32_t s = 0; s < plan.subdomains; ++s) {
    first.push_back(plan.parts_with(SubdomainId(s)).first.value);
    count.push_back(plan.parts_with(SubdomainId(s)).count);
  }
  EXPECT_THAT(first, ElementsAre(0, 0, 0, 3, 3, 3, 3, 3, 3, 9));
  EXPECT_THAT(count, ElementsAre(3, 3, 3, 6, 6, 6, 6, 6, 6, 1));
}

MetricMesh coarse_ball(double size) {
  MetricMesh whole{support::ball(1, 2), {}};
  const double l = -2 * std::log(size);
  whole.log_metrics.assign(whole.mesh.points.size(), {l, 0, l, 0, 0, l});
  return whole;
}

TEST(Phases, AreSeveralWhereACurvedInputIsCoarserThanWanted) {
  EXPECT_THAT(coarseness_of_phases(coarse_ball(0.1), 4), ElementsAre(4, 2, 1));
  EXPECT_FALSE(plan_for(coarse_ball(0.1), 4).coarsens);
  EXPECT_THAT(coarseness_of_phases(coarse_ball(0.05), 4), ElementsAre(8, 4, 2, 1));
  EXPECT_THAT(coarseness_of_phases(coarse_ball(0.1), 1), ElementsAre(1));
  EXPECT_TRUE(plan_for(far_from_its_metric(10, 3000), 4).coarsens);
}

/// Chords of the boundary that stay in the interface bend the fine triangles beside them.
TEST(Phases, LeaveNoPoorTetsAtACurvedBoundaryThatWasCoarse) {
  const MetricMesh whole = coarse_ball(0.08);
  Setting setting;
  setting.subdomains = 8;
  engine::LoopbackNetwork network(1);
  adapt_on_rank(network.transport(engine::Rank(0)), whole, setting, [&](RankOutcome rank) {
    const meshing::Measures measures = partition::measure_pieces(rank.peers, rank.result.pieces);
    EXPECT_GT(measures.quality_min, 0.1);
    EXPECT_GT(measures.quality_q01, 0.68);
    EXPECT_GT(measures.edges_unit, 0.96);
    std::size_t largest = 0, all = 0;
    for (const MeshPiece& piece : rank.result.pieces) {
      largest = std::max(largest, piece.mesh.tets.size());
      all += piece.mesh.tets.size();
    }
    EXPECT_LT(largest, all / 2) << "nobody gets it all";
  });
}

/// Pauses and checks change nothing, with one phase and with several, and see every shift.
TEST_P(AdaptationOnRanks, ChecksAfterEveryRoundLeaveTheBytesAsTheyAre) {
  for (const bool coarse_first : {false, true}) {
    const MetricMesh whole = coarse_first ? far_from_its_metric(7, 700) : near_its_metric(4);
    Setting setting;
    setting.balancer = engine::rotate();
    const PieceBytes expected = on_one_rank(whole, setting);
    setting.check = true;
    on_ranks(GetParam(), [&](Transport& network) {
      adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
        EXPECT_EQ(rank.plan.phases.size() > 1, coarse_first);
        EXPECT_GE(rank.result.checks, 3u) << "start, interiors, a shift";
        std::uint64_t rounds = 0;
        for (const auto& records : rank.result.shifts)
          for (const ShiftRecord& r : records) rounds = std::max(rounds, r.round + 1);
        rounds = partition::max(rank.peers, rounds);
        EXPECT_GE(rank.result.checks, rounds + 2);
        const PieceBytes all = gather_bytes(rank.peers, rank.result.pieces);
        EXPECT_TRUE(rank.peers.rank() > 0 || all == expected);
      });
    });
  }
}

TEST_P(AdaptationOnRanks, AViolationEndsTheRunOnAllRanks) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.25);
  Setting setting;
  setting.check = true;
  setting.balancer = engine::no_balancing();
  std::map<partition::SubdomainId, int> checks;
  std::mutex mutex;
  setting.on_check = [&](partition::Subdomain& s) {
    const std::lock_guard lock(mutex);
    if (++checks[s.id] != 3 || s.id.value != 2 || s.interface.size() == 0)
      return;  // the one after the division
    const meshing::VertexId v = s.interface.local(0);
    meshing::Point p = s.mesh->point(v);
    p.x = std::nextafter(p.x, 2);
    s.mesh->set_point(v, p);
  };
  std::atomic<int> violations{0};
  on_ranks(GetParam(), [&](Transport& network) {
    try {
      adapt_on_rank(network, whole, setting, [](RankOutcome) { FAIL() << "nothing was noticed"; });
    } catch (const partition::InvariantViolation& error) {
      ++violations;
      EXPECT_THAT(error.what(), ::testing::HasSubstr("violated after the adaptation of the interiors\n"));
      EXPECT_THAT(error.what(), ::testing::ContainsRegex("subdomains? .*2.*differ in place .found on rank"));
    }
  });
  EXPECT_GE(violations.load(), 1);
}

TEST_P(AdaptationOnRanks, ARunThatEndsByItsLimitOfShiftsSaysSo) {
  const MetricMesh whole = metric_mesh(unit_cube(4), 0.2);
  for (const std::uint32_t most : {0u, 12u}) {
    Setting setting;
    setting.most_shifts = most;
    on_ranks(GetParam(), [&](Transport& network) {
      adapt_on_rank(network, whole, setting, [&](RankOutcome rank) {
        const auto says = ::testing::HasSubstr("the run ended by its limit of 0 shifts: 5 of 5 subdomains");
        if (most == 0)
          EXPECT_THAT(rank.result.warnings, ::testing::Contains(says));
        else
          EXPECT_THAT(rank.result.warnings, ElementsAre());
      });
    });
  }
}

TEST(SubdomainOf, IsTheInverseOfObjectOf) {
  AdaptationPlan plan;
  plan.subdomains = 11;
  plan.first_object = 2;
  for (const int ranks : {1, 2, 3, 8, 20}) {
    for (SubdomainId s(0); s.value < plan.subdomains; ++s.value)
      EXPECT_EQ(subdomain_of(plan, ranks, object_of(plan, ranks, s).id), s) << ranks;
    EXPECT_FALSE(subdomain_of(plan, ranks, {engine::Rank(0), 1})) << "a mailbox";
    EXPECT_FALSE(subdomain_of(plan, ranks, {engine::Rank(0), 20})) << "beyond them all";
  }
  EXPECT_FALSE(subdomain_of(AdaptationPlan{}, 1, {engine::Rank(0), 1})) << "there is no plan yet";
}

}  // namespace
}  // namespace weft::graph::adaptation::adaptation_test

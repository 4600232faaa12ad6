#include "tests/support/simulated_run.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <random>
#include <tuple>

#include "graph/adaptation/subdomain_task.h"

namespace weft::testing {
namespace {

using engine::ObjectId;
using engine::Rank;
using graph::dataflow::EdgeIndex;
using graph::dataflow::ExecutionLog;
using graph::dataflow::GraphDescription;
using graph::dataflow::NodeIndex;

constexpr std::int64_t kMicrosecond = 1000;

NodeIndex node_named(const GraphDescription& graph, const std::string& name) {
  const auto found = std::find_if(graph.nodes.begin(), graph.nodes.end(),
                                  [&](const auto& node) { return node.name == name; });
  return static_cast<NodeIndex>(found - graph.nodes.begin());
}

EdgeIndex edge_between(const GraphDescription& graph, NodeIndex from, NodeIndex to) {
  const auto found = std::find_if(graph.edges.begin(), graph.edges.end(),
                                  [&](const auto& edge) { return edge.from == from && edge.to == to; });
  return static_cast<EdgeIndex>(found - graph.edges.begin());
}

struct Handler {
  std::int64_t ready = 0;
  std::uint64_t number = 0;  ///< makes the order total
  std::uint32_t subdomain = 0;
  std::uint64_t round = 0;
  NodeIndex node = 0;
  bool operator>(const Handler& o) const { return std::tie(ready, number) > std::tie(o.ready, o.number); }
};

class Simulation {
 public:
  explicit Simulation(const SimulationRules& rules);
  SimulatedRun run();

 private:
  struct Arrivals {
    std::size_t count = 0;
    std::uint64_t bytes = 0;
    std::int64_t latest = 0;
  };
  struct Name {
    NodeIndex interior, registered, propose, gather, scatter, shifted, update;
  };

  std::int64_t draw(std::int64_t least, std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(least, most)(random_);
  }
  void schedule(std::uint32_t subdomain, NodeIndex node, std::uint64_t round, std::int64_t ready);
  void handle(const Handler& handler);
  void node(NodeIndex index, std::uint64_t round, std::int64_t seconds);
  void count_what_is_left(int step);
  void pass(NodeIndex from, NodeIndex to, std::uint64_t round);
  void send_to_neighbours(NodeIndex from, NodeIndex to, std::uint64_t round, std::uint64_t bytes);
  void arrive(std::uint32_t subdomain, NodeIndex event, std::uint64_t round, std::int64_t time,
              std::uint64_t bytes);
  void propose_or_end(NodeIndex before, std::uint64_t round);
  void join_neighbours();
  void finish(SimulatedRun& run);
  engine::RankSummary summary_of(std::uint32_t rank, const SimulatedRun& run) const;

  SimulationRules rules_;
  std::mt19937_64 random_;
  SimulatedRun run_;
  Name name_{};
  std::priority_queue<Handler, std::vector<Handler>, std::greater<>> ready_;
  std::uint64_t handlers_ = 0;
  std::map<std::tuple<std::uint32_t, NodeIndex, std::uint64_t>, Arrivals> arrived_;
  std::vector<std::int64_t> free_at_;   ///< of subdomains
  std::vector<std::uint32_t> rank_of_;  ///< of subdomains
  std::vector<double> size_;            ///< of subdomains
  std::vector<std::vector<std::int64_t>> workers_free_at_;
  std::vector<std::int64_t> skew_;
  std::vector<std::vector<engine::Span>> spans_;      ///< by rank * workers + worker
  std::vector<std::vector<engine::Volume>> volumes_;  ///< by rank and peer
  std::vector<engine::Volume> traffic_;
  // The handler that runs.
  std::uint32_t subdomain_ = 0, rank_ = 0;
  std::int64_t now_ = 0;
  std::int64_t node_begin_ = 0;
};

Simulation::Simulation(const SimulationRules& rules)
    : rules_(rules),
      random_(rules.seed),
      free_at_(rules.subdomains),
      workers_free_at_(rules.ranks, std::vector<std::int64_t>(rules.workers)),
      spans_(rules.ranks * rules.workers),
      volumes_(rules.ranks, std::vector<engine::Volume>(rules.ranks)),
      traffic_(rules.ranks) {
  const GraphDescription& g = run_.graph =
      graph::dataflow::blueprint_of<graph::adaptation::SubdomainTask>().description();
  name_ = {node_named(g, "adapt interior"), node_named(g, "register interface"),
           node_named(g, "propose"),        node_named(g, "gather"),
           node_named(g, "scatter"),        node_named(g, "adapt shifted"),
           node_named(g, "update topology")};
  for (std::uint32_t s = 0; s < rules.subdomains; ++s) {
    rank_of_.push_back(static_cast<std::uint32_t>(std::uint64_t{s} * rules.ranks / rules.subdomains));
    size_.push_back(0.4 + 1.2 * static_cast<double>(draw(0, 1000)) / 1000 + 0.5 * s / rules.subdomains);
  }
  for (std::uint32_t r = 0; r < rules.ranks; ++r)
    skew_.push_back(1'000'000'000 + draw(-rules.largest_skew, rules.largest_skew));
  join_neighbours();
}

/// A ring with chords.
void Simulation::join_neighbours() {
  run_.neighbours.resize(rules_.subdomains);
  for (std::uint32_t s = 0; s < rules_.subdomains; ++s) {
    for (const std::uint32_t step : {1u, 7u}) {
      const std::uint32_t other = (s + step) % rules_.subdomains;
      auto& mine = run_.neighbours[s];
      if (other == s || std::find(mine.begin(), mine.end(), other) != mine.end()) continue;
      mine.push_back(other);
      run_.neighbours[other].push_back(s);
    }
  }
}

void Simulation::schedule(std::uint32_t subdomain, NodeIndex node, std::uint64_t round, std::int64_t ready) {
  ready_.push({ready, handlers_++, subdomain, round, node});
}

void Simulation::node(NodeIndex index, std::uint64_t round, std::int64_t duration) {
  graph::dataflow::NodeRun run;
  run.node = index, run.instance = object_of_subdomain(rules_, subdomain_), run.round = round;
  run.rank = Rank(static_cast<std::int32_t>(rank_));
  run.begin = now_ + skew_[rank_];
  node_begin_ = now_;
  now_ += duration;
  run.end = now_ + skew_[rank_];
  const auto arrivals = arrived_.find({subdomain_, index, round});
  if (arrivals != arrived_.end()) run.bytes_received = arrivals->second.bytes;
  run.first_counter = static_cast<std::uint32_t>(run_.log.counters.size());
  run_.log.runs.push_back(run);
  run_.log.count("processor, seconds", 0.5e-9 * static_cast<double>(duration));  // another had the other half
  if (index == name_.interior) run_.log.count("tets predicted", 40'000 * size_[subdomain_]);
  if (index == name_.interior || index == name_.shifted)
    count_what_is_left(index == name_.interior ? 0 : static_cast<int>(round) + 1);
  if (index == name_.propose) run_.log.count("vertices wanted", static_cast<double>(4'000 >> (2 * round)));
  if (index == name_.gather) run_.log.count("tets sent", static_cast<double>(9'000 >> round));
}

/// The names of subdomain_task.cpp. The interior is soon right, the interface later.
void Simulation::count_what_is_left(int step) {
  const double tets = 40'000 * size_[subdomain_];
  const auto count = [&](const char* what, double in_interior, double at_interface) {
    run_.log.count(std::string(what) + ", interior", std::floor(in_interior));
    run_.log.count(std::string(what) + ", interface", std::floor(at_interface));
  };
  count("tets", 0.7 * tets, 0.3 * tets);
  count("poor tets", 1e-5 * tets, 1e-2 * tets / (1 << 2 * step));
  count("long edges", 1e-2 * tets, 3e-2 * tets / (1 << step));
  count("short edges", 1e-3 * tets, 1e-2 * tets / (1 << step));
}

void Simulation::pass(NodeIndex from, NodeIndex to, std::uint64_t round) {
  run_.log.uses.push_back({edge_between(run_.graph, from, to), object_of_subdomain(rules_, subdomain_),
                           object_of_subdomain(rules_, subdomain_), round, 0,
                           Rank(static_cast<std::int32_t>(rank_)), now_ + skew_[rank_]});
}

void Simulation::send_to_neighbours(NodeIndex from, NodeIndex to, std::uint64_t round, std::uint64_t bytes) {
  for (const std::uint32_t other : run_.neighbours[subdomain_]) {
    const std::int64_t time = draw(node_begin_, now_);
    const std::uint64_t size =
        bytes / 2 + static_cast<std::uint64_t>(draw(0, static_cast<std::int64_t>(bytes)));
    run_.log.uses.push_back({edge_between(run_.graph, from, to), object_of_subdomain(rules_, subdomain_),
                             object_of_subdomain(rules_, other), round, size,
                             Rank(static_cast<std::int32_t>(rank_)), time + skew_[rank_]});
    const std::uint32_t there = rank_of_[other];
    volumes_[rank_][there].sent.add(size), traffic_[rank_].sent.add(size);
    volumes_[there][rank_].received.add(size), traffic_[there].received.add(size);
    arrive(other, to, round, time + 20 * kMicrosecond, size);
  }
}

void Simulation::arrive(std::uint32_t subdomain, NodeIndex event, std::uint64_t round, std::int64_t time,
                        std::uint64_t bytes) {
  Arrivals& all = arrived_[{subdomain, event, round}];
  all.bytes += bytes;
  all.latest = std::max(all.latest, time);
  // The subdomain itself declares the event: one more than it has neighbours.
  if (++all.count == run_.neighbours[subdomain].size() + 1) schedule(subdomain, event, round, all.latest);
}

void Simulation::propose_or_end(NodeIndex before, std::uint64_t round) {
  if (round >= rules_.rounds) return;
  pass(before, name_.propose, round);
  node(name_.propose, round, draw(200, 600) * kMicrosecond);
  send_to_neighbours(name_.propose, name_.gather, round, 4'000);
  arrive(subdomain_, name_.gather, round, now_, 0);
}

void Simulation::handle(const Handler& handler) {
  subdomain_ = handler.subdomain;
  if (rules_.migration && draw(0, 3) == 0)
    rank_of_[subdomain_] = static_cast<std::uint32_t>(draw(0, rules_.ranks - 1));
  rank_ = rank_of_[subdomain_];
  auto& workers = workers_free_at_[rank_];
  const auto worker = std::min_element(workers.begin(), workers.end());
  now_ = std::max({handler.ready, free_at_[subdomain_], *worker}) + draw(1, 5) * kMicrosecond;
  const std::int64_t begin = now_;
  const auto work = [&](double milliseconds) {
    return static_cast<std::int64_t>(1e6 * milliseconds * size_[subdomain_] * (0.7 + 6e-4 * draw(0, 1000)));
  };
  node(handler.node, handler.round,
       work(handler.node == name_.interior ? 425
            : handler.node == name_.gather ? 8
                                           : 4));
  if (handler.node == name_.interior) {
    send_to_neighbours(name_.interior, name_.registered, handler.round, 30'000);
    arrive(subdomain_, name_.registered, handler.round, now_, 0);
  } else if (handler.node == name_.registered) {
    propose_or_end(name_.registered, handler.round);
  } else if (handler.node == name_.gather) {
    send_to_neighbours(name_.gather, name_.scatter, handler.round, 400'000);
    arrive(subdomain_, name_.scatter, handler.round, now_, 0);
  } else if (handler.node == name_.scatter) {
    send_to_neighbours(name_.scatter, name_.update, handler.round, 8'000);
    arrive(subdomain_, name_.update, handler.round, now_, 0);
    pass(name_.scatter, name_.shifted, handler.round);
    node(name_.shifted, handler.round, work(120.0 / static_cast<double>(handler.round + 1)));
  } else {
    propose_or_end(name_.update, handler.round + 1);
  }
  free_at_[subdomain_] = *worker = now_;
  const auto lane = rank_ * rules_.workers + static_cast<std::uint32_t>(worker - workers.begin());
  spans_[lane].push_back({begin + skew_[rank_], now_ + skew_[rank_], object_of_subdomain(rules_, subdomain_),
                          handler.node, engine::Activity::compute, 0});
  run_.wall = std::max(run_.wall, now_);
}

SimulatedRun Simulation::run() {
  for (std::uint32_t s = 0; s < rules_.subdomains; ++s)
    schedule(s, name_.interior, 0, draw(0, 1000) * kMicrosecond);
  while (!ready_.empty()) {
    const Handler next = ready_.top();
    ready_.pop();
    handle(next);
  }
  finish(run_);
  return std::move(run_);
}

void Simulation::finish(SimulatedRun& run) {
  std::vector<std::string> methods;
  for (const auto& node : run.graph.nodes) methods.push_back("subdomain::" + node.name);
  std::vector<engine::RankSummary> summaries;
  for (std::uint32_t r = 0; r < rules_.ranks; ++r) {
    engine::RankTimeline timeline{Rank(static_cast<std::int32_t>(r)), 0, methods, {}};
    for (std::uint32_t w = 0; w < rules_.workers; ++w)
      timeline.lanes.push_back({"worker " + std::to_string(w), spans_[r * rules_.workers + w], {}, 0});
    run.timelines.push_back(std::move(timeline));
    summaries.push_back(summary_of(r, run));
  }
  run.summary = engine::merge(std::move(summaries));
}

engine::RankSummary Simulation::summary_of(std::uint32_t rank, const SimulatedRun& run) const {
  engine::RankSummary summary;
  summary.rank = Rank(static_cast<std::int32_t>(rank));
  summary.workers = static_cast<int>(rules_.workers);
  summary.wall = 1e-9 * static_cast<double>(run.wall);
  for (std::uint32_t w = 0; w < rules_.workers; ++w) {
    double compute = 0;
    for (const engine::Span& span : spans_[rank * rules_.workers + w])
      compute += 1e-9 * static_cast<double>(span.end - span.begin);
    summary.worker_compute.push_back(compute);
    summary.times.compute += compute;
  }
  const double available = rules_.workers * summary.wall;
  summary.times.unpack = 0.1 * (available - summary.times.compute);
  summary.times.idle = available - summary.times.compute - summary.times.unpack;
  summary.times.pack = 0.01 * summary.wall, summary.times.communication = 0.05 * summary.wall;
  summary.traffic[static_cast<std::size_t>(engine::Traffic::invoke)] = traffic_[rank];
  for (std::uint32_t p = 0; p < rules_.ranks; ++p) {
    const engine::Volume& volume = volumes_[rank][p];
    if (volume.sent.messages + volume.received.messages > 0)
      summary.peers.push_back({Rank(static_cast<std::int32_t>(p)), volume});
  }
  summary.network_calls = {{"MPI_Isend", 120 + static_cast<long>(rank)}, {"MPI_Iprobe", 4000}};
  summary.counters = {{"steals", 2.0 * rank}};
  summary.peak_rss = 400'000'000 + 1'000'000 * rank;
  return summary;
}

}  // namespace

SimulatedRun simulate(const SimulationRules& rules) { return Simulation(rules).run(); }

ObjectId object_of_subdomain(const SimulationRules& rules, std::uint32_t subdomain) {
  return {Rank(static_cast<std::int32_t>(subdomain % rules.ranks)), 1 + subdomain / rules.ranks};
}

std::uint64_t subdomain_of_object(const SimulationRules& rules, ObjectId object) {
  return std::uint64_t{object.number - 1} * rules.ranks + static_cast<std::uint64_t>(object.home.value);
}

}  // namespace weft::testing

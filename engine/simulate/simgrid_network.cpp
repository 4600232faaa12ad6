// SimGrid's flow model of a network: links are shared fairly (max-min) by the flows that pass them, routes
// are those of the topology. SimGrid's clock follows the simulation's, never ahead of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <queue>
#include <set>
#include <simgrid/s4u.hpp>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "engine/simulate/flow_network.h"

namespace weft::engine {
namespace {

namespace sg4 = simgrid::s4u;

/// SimGrid takes dates that differ by 1e-5 for the same: its second is a microsecond here.
constexpr double kUnit = 1e-3;  ///< of SimGrid, in a nanosecond
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

unsigned int up(double x) { return static_cast<unsigned int>(std::ceil(x)); }

/// N ranks a leaf switch, each joined to all of N / 2 switches above: uplinks have half the bandwidth of the
/// ports below, as in the first model's tree, but each flow has one of them, by its target.
sg4::FatTreeParams fat_tree(int ranks, int per_switch) {
  const auto n = static_cast<unsigned int>(per_switch);
  return {2, {n, up(static_cast<double>(ranks) / per_switch)}, {1, std::max(1u, n / 2)}, {1, 1}};
}

/// N ranks a router; all routers of a group are joined, and each group to each other by one link of one
/// router. Kim et al., Technology-Driven, Highly-Scalable Dragonfly Topology, ISCA 2008.
sg4::DragonflyParams dragonfly(int ranks, int per_router) {
  const double routers = std::ceil(static_cast<double>(ranks) / per_router);
  const unsigned int a_group = up(std::sqrt(routers));
  return {{up(routers / a_group), 1}, {1, 1}, {a_group, 1}, static_cast<unsigned int>(per_router)};
}

/// What happens at a signal, or when nobody catches, is the program's business: SimGrid's engine would change
/// it.
class KeptHandlers {
 public:
  KeptHandlers() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], nullptr, &actions_[i]);
  }
  ~KeptHandlers() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &actions_[i], nullptr);
    std::set_terminate(terminate_);
  }
  KeptHandlers(const KeptHandlers&) = delete;
  KeptHandlers& operator=(const KeptHandlers&) = delete;

 private:
  static constexpr std::array kSignals = {SIGINT, SIGSEGV, SIGBUS};
  std::array<struct sigaction, kSignals.size()> actions_{};
  std::terminate_handler terminate_ = std::get_terminate();
};

class SimGridNetwork final : public FlowNetwork {
 public:
  SimGridNetwork(const NetworkModel& network, int ranks) : arguments_(configuration()), engine_(nullptr) {
    const KeptHandlers kept;
    int count = static_cast<int>(arguments_.size());
    std::vector<char*> words;
    for (std::string& word : arguments_) words.push_back(word.data());
    words.push_back(nullptr);
    engine_ = std::make_unique<sg4::Engine>(&count, words.data());
    begin_ = sg4::Engine::get_clock();
    build(network, ranks);
    current_ = this;
    static const bool connected = [] {
      sg4::Activity::on_completion_cb([](const sg4::Activity& done) {
        if (current_ != nullptr) current_->completed(done);
      });
      return true;
    }();
    static_cast<void>(connected);
    // SimGrid's loop ends when an activity is vetoed: the way to stop it at an arrival.
    sg4::Activity::set_vetoed_activities(&stop_);
  }

  ~SimGridNetwork() override {
    current_ = nullptr;
    sg4::Activity::set_vetoed_activities(nullptr);
  }

  void send(std::uint64_t packet, Rank from, Rank to, std::size_t bytes, std::int64_t time) override {
    waiting_.push({time, packet, from, to, bytes});
  }

  std::vector<Arrival> advance(std::int64_t until) override {
    for (;;) {
      const std::int64_t next = waiting_.empty() ? kNever : waiting_.top().time;
      run_until(std::min(next, until));
      if (!arrived_.empty()) return take_arrived(until);
      if (next > until || next == kNever) return {};
      while (!waiting_.empty() && waiting_.top().time == next) {
        start(waiting_.top());
        waiting_.pop();
      }
    }
  }

 private:
  struct Waiting {
    std::int64_t time;
    std::uint64_t packet;
    Rank from, to;
    std::size_t bytes;
    bool operator<(const Waiting& other) const {  // the first has the highest priority
      return std::tie(time, packet) > std::tie(other.time, other.packet);
    }
  };

  /// Every factor that corrects for TCP is off: what is left is latency, bandwidth and sharing.
  static std::vector<std::string> configuration() {
    return {"weft",
            "--cfg=network/model:CM02",
            "--cfg=network/crosstraffic:0",
            "--cfg=network/TCP-gamma:0",
            "--cfg=network/weight-S:0",
            "--log=root.threshold:critical"};
  }

  /// Half of the latency a link: two ports of a switch are two links apart.
  void build(const NetworkModel& network, int ranks) {
    const double bandwidth = network.bandwidth * 1e-6, latency = network.latency * 1e6 / 2;
    const sg4::ClusterCallbacks ports([this](sg4::NetZone* zone, const auto&, unsigned long id) {
      sg4::Host* host = zone->create_host("rank " + std::to_string(id), 1);
      hosts_.push_back(host);
      return std::pair<simgrid::kernel::routing::NetPoint*, simgrid::kernel::routing::NetPoint*>(
          host->get_netpoint(), nullptr);
    });
    constexpr auto kDuplex = sg4::Link::SharingPolicy::SPLITDUPLEX;
    const int per_switch = std::min(network.switch_ranks, ranks);  // SimGrid makes a host for each
    sg4::NetZone* zone = network.topology == Topology::fat_tree
                             ? sg4::create_fatTree_zone("network", nullptr, fat_tree(ranks, per_switch),
                                                        ports, bandwidth, latency, kDuplex)
                             : sg4::create_dragonfly_zone("network", nullptr, dragonfly(ranks, per_switch),
                                                          ports, bandwidth, latency, kDuplex);
    zone->seal();
  }

  void start(const Waiting& packet) {
    const sg4::CommPtr flow =
        sg4::Comm::sendto_init(hosts_.at(packet.from.index()), hosts_.at(packet.to.index()));
    flow->set_payload_size(std::max<std::size_t>(packet.bytes, 1));
    flows_.emplace(flow.get(), std::pair{flow, packet.packet});
    flow->start();
    stop_.clear();  // it was vetoed while it had a source and no target
  }

  /// To `time`, or until packets arrive.
  void run_until(std::int64_t time) {
    if (flows_.empty() && time == kNever) return;
    if (time == kNever) return engine_->run();
    const double date = begin_ + kUnit * static_cast<double>(time);
    if (date > sg4::Engine::get_clock() + 1e-5) engine_->run_until(date);
  }

  void completed(const sg4::Activity& flow) {
    const auto found = flows_.find(&flow);
    if (found == flows_.end()) return;
    arrived_.push_back({found->second.second, std::llround((sg4::Engine::get_clock() - begin_) / kUnit)});
    done_.push_back(&flow);
    stop_.insert(found->second.first.get());
  }

  std::vector<Arrival> take_arrived(std::int64_t until) {
    stop_.clear();
    for (const sg4::Activity* flow : std::exchange(done_, {})) flows_.erase(flow);
    std::vector<Arrival> arrived = std::exchange(arrived_, {});
    for (Arrival& arrival : arrived) arrival.time = std::min(arrival.time, until);
    return arrived;
  }

  static inline SimGridNetwork* current_ = nullptr;
  std::vector<std::string> arguments_;
  std::unique_ptr<sg4::Engine> engine_;
  double begin_ = 0;  ///< its clock, which is never set back
  std::vector<sg4::Host*> hosts_;
  std::priority_queue<Waiting> waiting_;
  std::unordered_map<const sg4::Activity*, std::pair<sg4::CommPtr, std::uint64_t>> flows_;
  std::vector<const sg4::Activity*> done_;
  std::vector<Arrival> arrived_;
  std::set<sg4::Activity*> stop_;
};

}  // namespace
}  // namespace weft::engine

extern "C" __attribute__((visibility("default"))) weft::engine::FlowNetwork* weft_simgrid_network(
    int interface, const weft::engine::NetworkModel* network, int ranks) {
  if (interface != weft::engine::kFlowInterface) return nullptr;
  return new weft::engine::SimGridNetwork(*network, ranks);
}

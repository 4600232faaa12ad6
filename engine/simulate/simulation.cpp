// Turns, clocks and packets of simulated ranks.
#include "engine/simulate/simulation.h"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <queue>
#include <stdexcept>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/base/arena.h"
#include "engine/base/text.h"
#include "engine/run/launch.h"
#include "engine/simulate/fiber.h"
#include "engine/simulate/flow_network.h"
#include "engine/simulate/shared_cores.h"
#include "engine/trace/trace.h"

namespace weft::engine {
namespace {

constexpr TimePoint kNever = std::numeric_limits<TimePoint>::max();
// Whoever waits for nothing at all gets on even so: rounds of such ranks must not stop the clocks.
constexpr TimePoint kShortestWait = 100;

TimePoint nanoseconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1'000'000'000 * time.tv_sec + time.tv_nsec;
}

/// Processor time of this thread, without what asking for it takes: the wall's time, less what this thread
/// was away from its processor. The system, which takes twenty times as long as the wall's clock, is asked
/// for that only where so much time has passed since the last reading that the thread may have been away.
class ProcessorClock {
 public:
  ProcessorClock() {
    for (int i = 0; i < 1000; ++i) {
      const TimePoint begin = now();
      reading_ = std::min(reading_, now() - begin);
    }
  }

  TimePoint now() {
    constexpr TimePoint kShortestAbsence = 1000;
    TimePoint wall = nanoseconds_of(CLOCK_MONOTONIC);
    if (wall - read_ >= kShortestAbsence) wall = ask(wall);
    read_ = wall;
    return time_ = std::max(time_, wall - away_);
  }
  /// Without what reading the clock takes: nothing for what takes no time.
  TimePoint since(TimePoint begin) { return std::max<TimePoint>(0, now() - begin - reading_); }

 private:
  TimePoint ask(TimePoint begin) {
    constexpr TimePoint kLongestQuestion = 10'000;  // beyond that the thread was away
    const TimePoint processor = nanoseconds_of(CLOCK_THREAD_CPUTIME_ID);
    const TimePoint wall = nanoseconds_of(CLOCK_MONOTONIC);
    asking_ += std::min(wall - begin, kLongestQuestion);
    away_ = std::max(away_, wall - (processor - asking_));
    return wall;
  }

  TimePoint read_ = 0;    ///< by the wall's clock
  TimePoint away_ = 0;    ///< and asking, until then
  TimePoint asking_ = 0;  ///< in all
  TimePoint time_ = 0;
  TimePoint reading_ = kNever;  ///< the least that is between two readings
};

TimePoint nanoseconds(double seconds) { return static_cast<TimePoint>(std::llround(1e9 * seconds)); }

class SimulatedRank;

/// All ranks, and whose turn comes next.
class Simulation {
 public:
  Simulation(const SimulationOptions& options, const std::function<void(Transport&)>& body);
  ~Simulation();

  SimulationResult run();

  // For the ranks.
  const SimulationOptions& options() const { return options_; }
  SimulatedRank& rank(Rank rank) { return *ranks_[rank.index()]; }
  void pass(Rank from, Rank to, Packet packet, TimePoint time);
  void schedule(Rank rank, TimePoint time, std::uint64_t turn) { turns_.push({time, next_++, rank, turn}); }
  void call_outside(const std::function<void()>& function) { outside_ = &function; }
  void depart(LeaveNotice notice);
  void close();
  const std::vector<LeaveNotice>& notices() const { return notices_; }
  ProcessorClock& processor() { return processor_; }
  const SharedCores& cores() const { return cores_; }
  void workers_run(int more, TimePoint time);
  bool all_closed() const { return closed_ == options_.ranks; }
  bool abandoned() const {
    return std::any_of(notices_.begin(), notices_.end(), [](const LeaveNotice& n) { return !n.will_close; });
  }

 private:
  struct Turn {
    TimePoint time;
    std::uint64_t number;
    Rank rank;
    std::uint64_t turn;  ///< of the rank; another one has been scheduled since if it is not its latest
    bool operator>(const Turn& other) const {
      return std::tie(time, number) > std::tie(other.time, other.number);
    }
  };
  void take_turns();
  bool is_stale(const Turn& turn) const;
  bool deliver(TimePoint until);
  void rouse_all();

  /// On its way through a FlowNetwork.
  struct Flying {
    Rank from, to;
    Packet packet;
  };

  const SimulationOptions options_;
  NetworkLinks links_;
  std::unique_ptr<FlowNetwork> flows_;  ///< null: `links_` says at once when a packet arrives
  std::unordered_map<std::uint64_t, Flying> flying_;
  ProcessorClock processor_;
  SharedCores cores_;
  std::vector<std::unique_ptr<SimulatedRank>> ranks_;
  std::priority_queue<Turn, std::vector<Turn>, std::greater<>> turns_;
  std::uint64_t next_ = 0;
  const std::function<void()>* outside_ = nullptr;
  std::vector<LeaveNotice> notices_;
  int closed_ = 0;
  SimulationResult result_;
};

class SimulatedRank final : public Transport, public VirtualTime {
 public:
  SimulatedRank(Simulation& simulation, Rank rank, const std::function<void(Transport&)>& body)
      : simulation_(simulation), rank_(rank), fiber_(simulation.options().stack_bytes, [this, &body] {
          skip();
          try {
            run_and_close(*this, body);
          } catch (...) {
            error_ = std::current_exception();
          }
          charge();
        }) {}

  // --- The simulation's side.
  void take_turn(TimePoint time) {
    clock_ = std::max(clock_, time);
    of_thread_ = this;
    fiber_.enter();
  }
  /// With its handler done outside.
  void go_on() { fiber_.enter(); }
  void end_turn() { of_thread_ = nullptr; }
  bool finished() const { return fiber_.finished(); }
  bool has_running_workers() const { return running_ > 0; }
  const std::exception_ptr& error() const { return error_; }
  TimePoint clock() const { return clock_; }
  std::uint64_t turn() const { return turn_; }

  void arrive(TimePoint time, Rank from, Packet packet) {
    packets_.push_back({time, packets_seen_++, from, std::move(packet)});
    std::push_heap(packets_.begin(), packets_.end(), std::greater<>());
    rouse(time);
  }
  /// It goes on no later than then.
  void rouse(TimePoint time) {
    if (!waits_ || time >= wakes_at_) return;
    wait_until(std::max(time, clock_));
  }

  // --- Transport
  Rank rank() const override { return rank_; }
  int size() const override { return simulation_.options().ranks; }
  std::size_t unsent(Rank) const override { return 0; }
  bool all_sent() const override { return true; }
  VirtualTime* virtual_time() override { return this; }

  void send(Rank to, Packet packet) override {
    if (packet.head.size() > kMaxHead)
      throw TransportError(
          text("a packet's head has ", packet.head.size(), " bytes; ", kMaxHead, " are allowed"));
    if (to.value < 0 || to.value >= size()) throw TransportError(text("there is no rank ", to.value));
    charge();
    spend_on_packet();
    simulation_.pass(rank_, to, std::move(packet), clock_);
    skip();
  }

  bool poll(const Receive& receive) override {
    bool any = false;
    // What comes while these are received has its turn next time, so that the rank gets to sending, too.
    const TimePoint time = now();
    while (!packets_.empty() && packets_.front().time <= time) {
      charge();
      std::pop_heap(packets_.begin(), packets_.end(), std::greater<>());
      Arrival arrival = std::move(packets_.back());
      packets_.pop_back();
      spend_on_packet();
      skip();
      receive(arrival.from, arrival.packet.head, std::move(arrival.packet.segments));
      any = true;
    }
    return any;
  }

  void wait(std::chrono::nanoseconds at_most) override {
    charge();
    TimePoint until = clock_ + (woken_.exchange(false) ? 0 : std::max<TimePoint>(at_most.count(), 0));
    until = std::max(until, clock_ + kShortestWait);
    if (!communicates()) {
      until = std::min(until, *core_at_);
    } else {
      core_at_.reset();
      if (!packets_.empty()) until = std::min(until, std::max(packets_.front().time, clock_));
    }
    sleep(until);
    if (!core_at_ && simulation_.cores().all_busy())
      core_at_ = clock_ + nanoseconds(simulation_.options().core_wait);
  }

  void wake() noexcept override { woken_ = true; }

  std::optional<LostPeer> lost_peer() override {
    if (simulation_.notices().empty()) return std::nullopt;
    return missed_in(phase(), simulation_.notices());
  }
  bool watches(Rank) const override { return true; }
  void leave(const std::string& why) noexcept override {
    simulation_.depart({rank_, ended_phase(), why, true});
  }
  void close() override {
    charge();
    simulation_.close();
    while (!simulation_.all_closed() && !simulation_.abandoned()) sleep(kNever);
    if (!simulation_.all_closed()) throw TransportError("a rank has abandoned the network");
  }
  void abandon() noexcept override {
    simulation_.depart({rank_, ended_phase(), "has abandoned the network", false});
  }

  // --- VirtualTime
  std::int64_t now() const override { return clock_ + measured(); }
  void spend(std::int64_t nanoseconds) override {
    clock_ += nanoseconds;
    if (!in_handler_) communicated_ += nanoseconds;
  }
  void copied(std::size_t bytes) override {
    const SimulationOptions& options = simulation_.options();
    if (!options.measured) spend(nanoseconds(static_cast<double>(bytes) / options.copy_rate));
  }
  std::int64_t run_handler(const std::function<void()>& handler) override {
    charge();
    const TimePoint begin = clock_;
    in_handler_ = true;
    // Handlers may need a deep stack, and what they use is not kept: they run on that of the thread.
    std::exception_ptr error;
    const std::function<void()> guarded = [&] {
      skip();
      try {
        handler();
      } catch (...) {
        error = std::current_exception();
      }
      charge();
    };
    simulation_.call_outside(guarded);
    fiber_.leave();
    skip();
    if (!simulation_.options().measured) clock_ += nanoseconds(simulation_.options().handler_overhead);
    in_handler_ = false;
    if (error) std::rethrow_exception(error);
    return std::exchange(clock_, begin) - begin;
  }
  void workers_run(int more) override {
    running_ += more;
    simulation_.workers_run(more, now());
  }
  std::int64_t worked(std::int64_t time) const override { return simulation_.cores().worked(time); }
  std::int64_t when(std::int64_t worked) const override { return simulation_.cores().when(worked); }
  bool communicates() const override { return !core_at_ || clock_ >= *core_at_; }
  std::int64_t communicated() const override { return communicated_ + (in_handler_ ? 0 : measured()); }

 private:
  struct Arrival {
    TimePoint time;
    std::uint64_t number;
    Rank from;
    Packet packet;
    bool operator>(const Arrival& other) const {
      return std::tie(time, number) > std::tie(other.time, other.number);
    }
  };

  void spend_on_packet() { spend(nanoseconds(simulation_.options().network.overhead)); }

  /// Since the last charge().
  TimePoint measured() const {
    if (!simulation_.options().measured) return 0;
    return scaled(simulation_.processor().since(charged_));
  }
  TimePoint scaled(TimePoint time) const {
    return static_cast<TimePoint>(static_cast<double>(time) * simulation_.options().slowdown);
  }
  void charge() {
    spend(measured());
    skip();
  }
  /// What has been done since the last charge() was the simulation's.
  void skip() {
    if (simulation_.options().measured) charged_ = simulation_.processor().now();
  }

  void sleep(TimePoint until) {
    waits_ = true;
    wait_until(until);
    fiber_.leave();
    waits_ = false;
    ++turn_;
    skip();
  }
  void wait_until(TimePoint until) {
    wakes_at_ = until;
    ++turn_;
    if (until != kNever) simulation_.schedule(rank_, until, turn_);
  }

  Simulation& simulation_;
  Rank rank_;
  std::exception_ptr error_;
  TimePoint clock_ = 0;
  TimePoint charged_ = 0;  ///< processor time at the last charge() or skip()
  TimePoint communicated_ = 0;
  bool in_handler_ = false;
  std::optional<TimePoint> core_at_;  ///< the communication thread has woken, and waits until then
  int running_ = 0;                   ///< workers
  std::atomic<bool> woken_{false};
  bool waits_ = false;
  TimePoint wakes_at_ = kNever;
  std::uint64_t turn_ = 0;
  std::uint64_t packets_seen_ = 0;
  std::vector<Arrival> packets_;  ///< a heap: the first is the earliest
  Fiber fiber_;
};

Simulation::Simulation(const SimulationOptions& options, const std::function<void(Transport&)>& body)
    : options_(options), links_(options.network, options.ranks), cores_(options.cores) {
  if (options.ranks < 1) throw std::invalid_argument(text("there cannot be ", options.ranks, " ranks"));
  if (has_flows(options.network.topology)) flows_ = make_flow_network(options.network, options.ranks);
  for (int r = 0; r < options.ranks; ++r) {
    ranks_.push_back(std::make_unique<SimulatedRank>(*this, Rank(r), body));
    schedule(Rank(r), 0, 0);
  }
}

Simulation::~Simulation() = default;

SimulationResult Simulation::run() {
  const TimePoint begin = now();
  take_turns();
  result_.real_seconds = 1e-9 * static_cast<double>(now() - begin);
  for (const auto& rank : ranks_) {
    if (rank->error()) std::rethrow_exception(rank->error());
    if (!rank->finished()) throw std::logic_error("the simulated ranks wait for each other for ever");
    result_.seconds = std::max(result_.seconds, 1e-9 * static_cast<double>(rank->clock()));
  }
  return result_;
}

bool Simulation::is_stale(const Turn& turn) const {
  const SimulatedRank& rank = *ranks_[turn.rank.index()];
  return rank.turn() != turn.turn || rank.finished();
}

void Simulation::take_turns() {
  for (;;) {
    while (!turns_.empty() && is_stale(turns_.top())) turns_.pop();
    // What arrives before the next turn may give another rank an earlier one. No rank sends before that time.
    if (deliver(turns_.empty() ? kNever : turns_.top().time)) continue;
    if (turns_.empty()) return;
    const Turn next = turns_.top();
    turns_.pop();
    SimulatedRank& rank = *ranks_[next.rank.index()];
    ++result_.turns;
    rank.take_turn(next.time);
    while (outside_ != nullptr) {
      (*std::exchange(outside_, nullptr))();
      rank.go_on();
    }
    rank.end_turn();
  }
}

/// Hands over the next packets that arrive from flows until then; false when there are none.
bool Simulation::deliver(TimePoint until) {
  if (flying_.empty()) return false;
  const std::vector<FlowNetwork::Arrival> arrivals = flows_->advance(until);
  for (const FlowNetwork::Arrival& arrival : arrivals) {
    Flying flying = std::move(flying_.extract(arrival.packet).mapped());
    rank(flying.to).arrive(arrival.time, flying.from, std::move(flying.packet));
  }
  return !arrivals.empty();
}

void Simulation::pass(Rank from, Rank to, Packet packet, TimePoint time) {
  std::size_t bytes = packet.head.size();
  for (const Blob& segment : packet.segments) bytes += segment.size();
  if (from != to) {
    ++result_.packets;
    result_.bytes += bytes;
    if (flows_) {
      flying_.emplace(result_.packets, Flying{from, to, std::move(packet)});
      return flows_->send(result_.packets, from, to, bytes, time);
    }
  }
  rank(to).arrive(links_.send(from, to, bytes, time), from, std::move(packet));
}

/// Others may be through earlier than they thought.
void Simulation::workers_run(int more, TimePoint time) {
  if (!cores_.run(more, time)) return;
  for (const auto& rank : ranks_)
    if (rank->has_running_workers()) rank->rouse(time);
}

void Simulation::depart(LeaveNotice notice) {
  notices_.push_back(std::move(notice));
  rouse_all();
}

void Simulation::close() {
  ++closed_;
  if (all_closed()) rouse_all();
}

void Simulation::rouse_all() {
  const TimePoint time = now();
  for (const auto& rank : ranks_) rank->rouse(time);
}

}  // namespace

SimulationResult simulate(const SimulationOptions& options, const std::function<void(Transport&)>& body) {
  Simulation simulation(options, body);
  SimulationResult result;
  Arena one_thread(1);
  std::exception_ptr error;
  one_thread.execute([&] {
    try {
      result = simulation.run();
    } catch (...) {
      error = std::current_exception();
    }
  });
  if (error) std::rethrow_exception(error);
  return result;
}

}  // namespace weft::engine

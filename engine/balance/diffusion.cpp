// First-order diffusion of load on a hypercube.
#include <algorithm>
#include <cmath>

#include "engine/balance/balancer.h"
#include "engine/balance/worth.h"

namespace weft::engine {
namespace {

constexpr TimePoint kPeriod =
    1'000'000;  ///< ns between two steps: well below the tasks that are worth moving
constexpr double kRelevantChange = 0.1;

class Diffusion final : public Balancer {
 public:
  Diffusion(Rank rank, int ranks) {
    for (int bit = 1; bit < ranks; bit <<= 1) {
      if ((rank.value ^ bit) < ranks) neighbours_.push_back({Rank(rank.value ^ bit), 0});
    }
  }

  void step(BalanceActions& actions, TimePoint time) override {
    if (neighbours_.empty()) return;
    const double mine = actions.load().queued_seconds;
    if (next_step_ && time < *next_step_) return;
    tell_neighbours(mine, actions);
    if (mine > 0) spread(mine, actions);
    // Time is only looked at while there is work: its arrival, or a neighbour's message, starts it again.
    next_step_ = mine > 0 ? std::optional(time + kPeriod) : std::nullopt;
  }

  void told(Rank from, const BalanceMessage& message, BalanceActions&) override {
    for (Neighbour& neighbour : neighbours_) {
      if (neighbour.rank == from) neighbour.seconds = message.seconds;
    }
  }

  std::optional<TimePoint> next_step() const override { return next_step_; }

 private:
  struct Neighbour {
    Rank rank;
    double seconds;  ///< its load, as it told last, and what was given to it since
  };

  void tell_neighbours(double mine, BalanceActions& actions) {
    if (std::abs(mine - told_) <= kRelevantChange * told_) return;
    told_ = mine;
    for (const Neighbour& neighbour : neighbours_) actions.tell(neighbour.rank, {0, mine});
  }

  void spread(double mine, BalanceActions& actions) {
    std::vector<ReadyObject> ready = actions.ready_objects();
    const double worth_it = worth_moving(actions);
    // Hardly any has moved yet: the first ones show what moving takes.
    std::size_t left = actions.move_seconds() ? ready.size() : 1;
    for (Neighbour& neighbour : neighbours_) {
      // What it told may have changed by as much as is not worth telling, and mine may be told wrong by as
      // much.
      if (mine - neighbour.seconds <= 3 * kRelevantChange * mine) continue;
      double flow = (mine - neighbour.seconds) / static_cast<double>(neighbours_.size() + 1);
      // The last in the queue are given. An object of more than the flow would only swap the roles, unless it
      // leaves the neighbour below what stays here.
      for (std::size_t i = ready.size(); i-- > 0 && flow > 0 && left > 0;) {
        const double seconds = ready[i].seconds;
        if (seconds < worth_it) continue;
        if (seconds > flow && neighbour.seconds + seconds > mine - seconds) continue;
        actions.move(ready[i].id, neighbour.rank);
        --left;
        flow -= seconds;
        mine -= seconds;
        neighbour.seconds += seconds;
        ready.erase(ready.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }

  std::vector<Neighbour> neighbours_;
  double told_ = 0;
  std::optional<TimePoint> next_step_;
};

}  // namespace

BalancerFactory diffusion() {
  return [](Rank rank, int ranks) { return std::make_unique<Diffusion>(rank, ranks); };
}

}  // namespace weft::engine

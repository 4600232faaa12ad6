// Work stealing with lifelines.
#include <algorithm>
#include <deque>
#include <random>
#include <unordered_set>

#include "engine/balance/balancer.h"
#include "engine/balance/worth.h"

namespace weft::engine {
namespace {

/// Seconds. What a rank has queued beyond this is work; the rest are messages that pass. A rank that has been
/// idle but for messages is remembered where it has asked, and need not ask again: with thousands of ranks
/// the questions would be most of what is sent.
constexpr double kWork = 1e-3;

class WorkStealing final : public Balancer {
 public:
  WorkStealing(Rank rank, int ranks)
      : rank_(rank), ranks_(ranks), random_(static_cast<unsigned>(rank.value) + 1) {}

  void step(BalanceActions& actions, TimePoint) override {
    const Load load = actions.load();
    if (load.queued_seconds > kWork) tried_ = 0;  // others may have heard of it, and forgotten this rank
    if (load.ready > 0) {
      feed_hungry(actions);
    } else if (load.busy < load.workers && !asking_ && tried_ < tries()) {
      ask(actions, load);
    }
  }

  void told(Rank from, const BalanceMessage& message, BalanceActions& actions) override {
    switch (static_cast<Kind>(message.kind)) {
      case Kind::ask:
        if (!give(from, message.seconds, actions)) {
          actions.tell(from, {static_cast<std::uint32_t>(Kind::later), 0});
          remember(from, actions);
        }
        break;
      case Kind::given:
        asking_ = false;
        tried_ = 0;
        break;
      case Kind::later:
        asking_ = false;
        step(actions, 0);
        break;
    }
  }

 private:
  enum class Kind : std::uint32_t { ask, given, later };

  /// Lifelines: the neighbours on a hypercube, so that work reaches every rank in a few steps; before them,
  /// as many others.
  int lifelines() const {
    int n = 0;
    while ((1 << n) < ranks_) ++n;
    return n;
  }
  int tries() const { return ranks_ > 1 ? 2 * lifelines() : 0; }

  Rank victim(const BalanceActions& actions) {
    if (tried_ == 0) {
      if (const Rank most = actions.most_loaded(); most.valid()) return most;
    }
    if (tried_ >= lifelines()) {
      const Rank neighbour(rank_.value ^ 1 << (tried_ - lifelines()));
      if (neighbour.value < ranks_) return neighbour;
    }
    const int other = std::uniform_int_distribution<int>(0, ranks_ - 2)(random_);
    return Rank(other + (other >= rank_.value ? 1 : 0));
  }

  void ask(BalanceActions& actions, const Load& load) {
    const Rank from = victim(actions);
    ++tried_;
    asking_ = true;
    actions.tell(from, {static_cast<std::uint32_t>(Kind::ask), load.queued_seconds});
  }

  /// Gives `to` about half of what this rank has more, in few objects: those of most work, of equal ones the
  /// last in the queue; at least one if there is any that is worth its way.
  bool give(Rank to, double their_seconds, BalanceActions& actions) {
    std::vector<ReadyObject> ready = actions.ready_objects();
    std::reverse(ready.begin(), ready.end());
    std::stable_sort(ready.begin(), ready.end(),
                     [](const ReadyObject& a, const ReadyObject& b) { return a.seconds > b.seconds; });
    const Load load = actions.load();
    // An object that a free worker here is about to take is none to spare.
    const auto spare = static_cast<std::ptrdiff_t>(ready.size()) - (load.workers - load.busy);
    if (spare <= 0) return false;
    const double more = load.queued_seconds - their_seconds, wanted = more / 2;
    const double worth_it = worth_moving(actions);
    // Hardly any has moved yet: the first ones show what moving takes.
    const std::ptrdiff_t most = actions.move_seconds() ? spare : 1;
    double given = 0;
    std::ptrdiff_t number = 0;
    for (const ReadyObject& object : ready) {
      if (number == most || object.seconds < worth_it) break;
      // The first one may be all that this rank has more: better done there at once than here later.
      if (given + object.seconds > (number == 0 ? more : wanted)) continue;
      actions.move(object.id, to);
      given += object.seconds;
      ++number;
      if (given >= wanted) break;
    }
    if (number == 0) return false;
    actions.tell(to, {static_cast<std::uint32_t>(Kind::given), given});
    return true;
  }

  void remember(Rank rank, BalanceActions& actions) {
    if (remembered_.insert(rank.value).second) hungry_.push_back(rank);
    actions.wake_when_ready(true);
  }

  void feed_hungry(BalanceActions& actions) {
    while (!hungry_.empty()) {
      const Rank hungry = hungry_.front();
      // It may have found work elsewhere since.
      const double known = actions.load_of(hungry);
      if (known <= std::max(kWork, actions.load().queued_seconds / 2) &&
          !give(hungry, std::max(known, 0.0), actions))
        return;
      remembered_.erase(hungry.value);
      hungry_.pop_front();
    }
    actions.wake_when_ready(false);
  }

  Rank rank_;
  int ranks_;
  std::minstd_rand random_;
  bool asking_ = false;
  int tried_ = 0;                                ///< ranks asked in vain since there was last work here
  std::deque<Rank> hungry_;                      ///< have asked in vain, each once
  std::unordered_set<std::int32_t> remembered_;  ///< the same
};

}  // namespace

BalancerFactory work_stealing() {
  return [](Rank rank, int ranks) { return std::make_unique<WorkStealing>(rank, ranks); };
}

}  // namespace weft::engine

// Work stealing with lifelines.
#include <algorithm>
#include <optional>
#include <random>
#include <unordered_set>
#include <utility>
#include <vector>

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

  void step(BalanceActions& actions, TimePoint time) override {
    const Load load = actions.load();
    if (load.queued_seconds > kWork) tried_ = 0;  // others may have heard of it, and forgotten this rank
    if (load.ready > 0) {
      offer_to_hungry(actions, load, time);
    } else {
      next_offers_.reset();
      ask_if_idle(actions, load);
    }
  }

  /// While some ask in vain, and there is work.
  std::optional<TimePoint> next_step() const override { return next_offers_; }

  void told(Rank from, const BalanceMessage& message, BalanceActions& actions) override {
    switch (static_cast<Kind>(message.kind)) {
      case Kind::ask:
        if (!give(from, message.seconds, actions)) {
          actions.tell(from, {static_cast<std::uint32_t>(Kind::later), 0});
          remember(from, actions);
        }
        break;
      case Kind::offer:
        offer_ = from;
        ask_if_idle(actions, actions.load());
        break;
      case Kind::given:
        asking_ = false;
        offer_.reset();
        tried_ = 0;
        break;
      case Kind::later:
        asking_ = false;
        ask_if_idle(actions, actions.load());
        break;
    }
  }

 private:
  enum class Kind : std::uint32_t { ask, given, later, offer };

  /// Lifelines: the neighbours on a hypercube, so that work reaches every rank in a few steps; before them,
  /// as many others.
  int lifelines() const {
    int n = 0;
    while ((1 << n) < ranks_) ++n;
    return n;
  }
  int tries() const { return ranks_ > 1 ? 2 * lifelines() : 0; }

  /// Of the nearest on the hypercube. Who numbers objects so that partners follow each other, as a bisection
  /// does, has them there.
  Rank most_loaded_near(const BalanceActions& actions) const {
    constexpr int kNear = 4;
    Rank most;
    double load_of_most = 0;
    for (int bits = 1; bits < kNear; ++bits) {
      const Rank near(rank_.value ^ bits);
      if (near.value >= ranks_) continue;
      if (const double load = actions.load_of(near); load > load_of_most) most = near, load_of_most = load;
    }
    return most;
  }

  Rank victim(const BalanceActions& actions) {
    if (tried_ == 0) {
      if (const Rank near = most_loaded_near(actions); near.valid()) return near;
    }
    if (tried_ <= 1) {
      if (const Rank most = actions.most_loaded(); most.valid()) return most;
    }
    if (tried_ >= lifelines()) {
      const Rank neighbour(rank_.value ^ 1 << (tried_ - lifelines()));
      if (neighbour.value < ranks_) return neighbour;
    }
    const int other = std::uniform_int_distribution<int>(0, ranks_ - 2)(random_);
    return Rank(other + (other >= rank_.value ? 1 : 0));
  }

  void ask_if_idle(BalanceActions& actions, const Load& load) {
    if (asking_ || load.ready > 0 || load.busy == load.workers) return;
    if (offer_) return ask(*std::exchange(offer_, {}), actions, load);
    if (tried_ == tries()) return;
    const Rank from = victim(actions);
    ++tried_;
    ask(from, actions, load);
  }

  void ask(Rank from, BalanceActions& actions, const Load& load) {
    asking_ = true;
    actions.tell(from, {static_cast<std::uint32_t>(Kind::ask), load.queued_seconds});
  }

  /// Objects that an idle rank could be given at most: one that a free worker here is about to take is none.
  static std::ptrdiff_t spare(const Load& load) {
    return static_cast<std::ptrdiff_t>(load.ready) - (load.workers - load.busy);
  }

  /// The ties of an object that is worth giving. What it does with partners passes the network for as long as
  /// it is away from them: four that it leaves behind count as much as moving it.
  static std::optional<int> ties_if_worth_giving(const ReadyObject& object, Rank to, double worth,
                                                 const BalanceActions& actions) {
    constexpr double kPartner = 0.25;
    if (object.seconds < worth) return std::nullopt;
    const int ties = actions.ties(object.id, to);
    if (object.seconds < worth * (1 + kPartner * std::max(0, -ties))) return std::nullopt;
    return ties;
  }

  struct Candidate {
    ReadyObject object;
    int ties;
  };

  /// What may be given, first what leaves fewest partners behind, of equal ones what has most work, then the
  /// last in the queue.
  static std::vector<Candidate> candidates(Rank to, const BalanceActions& actions) {
    std::vector<Candidate> all;
    const double worth = worth_moving(actions);
    for (const ReadyObject& object : actions.ready_objects())
      if (const auto ties = ties_if_worth_giving(object, to, worth, actions)) all.push_back({object, *ties});
    std::ranges::reverse(all);
    std::ranges::stable_sort(all, [](const Candidate& a, const Candidate& b) {
      return std::pair(-a.ties, -a.object.seconds) < std::pair(-b.ties, -b.object.seconds);
    });
    return all;
  }

  /// Gives `to` about half of what this rank has more, in few objects; at least one if there is any that is
  /// worth its way.
  bool give(Rank to, double their_seconds, BalanceActions& actions) {
    const Load load = actions.load();
    if (spare(load) <= 0) return false;
    const double wanted = (load.queued_seconds - their_seconds) / 2;
    // Hardly any has moved yet: the first ones show what moving takes.
    const std::ptrdiff_t most = actions.move_seconds() ? spare(load) : 1;
    double given = 0;
    std::ptrdiff_t number = 0;
    for (const auto& [object, ties] : candidates(to, actions)) {
      if (number == most) break;
      // The first one may be all that this rank has: better done there at once than here later.
      if (number > 0 && given + object.seconds > wanted) continue;
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

  /// They may have found work elsewhere since, and ask again if not.
  void offer_to_hungry(BalanceActions& actions, const Load& load, TimePoint time) {
    constexpr TimePoint kPause = 200'000;  // to look for what to give takes longer than most messages
    if (hungry_.empty() || load.queued_seconds <= kWork || spare(load) <= 0) return next_offers_.reset();
    if (next_offers_ && time < *next_offers_) return;
    next_offers_ = time + kPause;
    const std::vector<ReadyObject> ready = actions.ready_objects();
    const double worth = worth_moving(actions);
    std::erase_if(hungry_, [&](Rank hungry) {
      if (std::ranges::none_of(ready, [&](const ReadyObject& object) {
            return ties_if_worth_giving(object, hungry, worth, actions).has_value();
          }))
        return false;
      actions.tell(hungry, {static_cast<std::uint32_t>(Kind::offer), 0});
      remembered_.erase(hungry.value);
      return true;
    });
    if (!hungry_.empty()) return;
    next_offers_.reset();
    actions.wake_when_ready(false);
  }

  Rank rank_;
  int ranks_;
  std::minstd_rand random_;
  bool asking_ = false;
  int tried_ = 0;                                ///< ranks asked in vain since there was last work here
  std::optional<Rank> offer_;                    ///< who has told of work last
  std::vector<Rank> hungry_;                     ///< have asked in vain, each once
  std::unordered_set<std::int32_t> remembered_;  ///< the same
  std::optional<TimePoint> next_offers_;         ///< when they may be told of work; empty: at once
};

}  // namespace

BalancerFactory work_stealing() {
  return [](Rank rank, int ranks) { return std::make_unique<WorkStealing>(rank, ranks); };
}

}  // namespace weft::engine

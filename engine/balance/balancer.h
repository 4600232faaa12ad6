// Policies that decide which objects move where while the run goes on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/base/rank.h"
#include "engine/schedule/load.h"
#include "engine/trace/trace.h"

namespace weft::engine {

/// What policies of two ranks tell each other.
struct BalanceMessage {
  std::uint32_t kind = 0;  ///< meaning is the policy's
  double seconds = 0;
};

/// A policy's view of its rank, and what it can do.
class BalanceActions {
 public:
  virtual ~BalanceActions() = default;

  virtual Rank rank() const = 0;
  virtual int ranks() const = 0;
  virtual Load load() const = 0;

  /// Objects that wait for a worker here and can move, in the order in which they would be handled.
  virtual std::vector<ReadyObject> ready_objects() const = 0;

  /// How many objects that it has sent messages to are on `to`, as far as this rank knows, less those here.
  virtual int ties(ObjectId id, Rank to) const = 0;

  /// Processor seconds that moving an object takes the ranks in all, judged by the latest that have moved
  /// from here; nothing while they are too few to judge by.
  virtual std::optional<double> move_seconds() const = 0;

  /// The load that another rank had when it last sent a packet here; -1: none yet.
  virtual double load_of(Rank rank) const = 0;
  /// Of the others the one with the greatest of these loads, if any is above 0.
  virtual Rank most_loaded() const {
    Rank most;
    for (int r = 0; r < ranks(); ++r) {
      const double load = Rank(r) == rank() ? 0 : load_of(Rank(r));
      if (load > 0 && (!most.valid() || load > load_of(most))) most = Rank(r);
    }
    return most;
  }

  /// Objects that wait for a worker; others only from finished(). An object that is moved where nothing waits
  /// for it may come after the run has ended, and be lost.
  virtual void move(ObjectId id, Rank to) = 0;
  virtual void tell(Rank to, const BalanceMessage& message) = 0;

  /// step() is to be called whenever objects start to wait for a worker here.
  virtual void wake_when_ready(bool on) = 0;
};

/// One rank's part of a balancing policy; called by its communication thread only. A policy acts on what
/// happens (work appears, work ends, a message comes) or on time while there is work; on an idle rank nothing
/// may be sent for ever, or the run would not end.
class Balancer {
 public:
  virtual ~Balancer() = default;

  /// Something may have changed. `time` is now.
  virtual void step(BalanceActions& actions, TimePoint time) = 0;
  virtual void told(Rank from, const BalanceMessage& message, BalanceActions& actions) = 0;

  /// Handlers of these objects have just run; only called if wants_finished().
  virtual void finished(const std::vector<ObjectId>&, BalanceActions&) {}
  virtual bool wants_finished() const { return false; }

  /// When to call step() though nothing happens.
  virtual std::optional<TimePoint> next_step() const { return std::nullopt; }
};

using BalancerFactory = std::function<std::unique_ptr<Balancer>(Rank rank, int ranks)>;

/// Objects stay where they are put.
BalancerFactory no_balancing();

/// A rank with an idle worker asks others, most loaded first as far as it knows, near ones before all, then
/// at random; a rank with work to spare gives half the difference, the objects with fewest partners here
/// first, another remembers the asker and tells it when it has some (lifelines along a hypercube, Saraswat et
/// al., PPoPP 2011). Nothing is sent while all are busy or all idle.
BalancerFactory work_stealing();

/// Neighbours on a hypercube tell each other their load when it changes and even it out by first-order
/// diffusion (Cybenko, J. Parallel Distrib. Comput. 7, 1989): slower than stealing, but it moves work before
/// anybody is idle.
BalancerFactory diffusion();

/// For tests: every object moves to a random other rank after `share` of its handlers.
BalancerFactory rotate(double share = 1.0, std::uint64_t seed = 1);

/// By name: none, stealing, diffusion, rotate. Throws std::invalid_argument that lists them.
BalancerFactory balancer_by_name(std::string_view name);

}  // namespace weft::engine

// The engine: one rank's mobile objects, workers and communication, run until there is nothing left to do.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/balance/balancer.h"
#include "engine/network/exchange.h"
#include "engine/network/transport.h"
#include "engine/objects/registry.h"
#include "engine/schedule/context.h"
#include "engine/schedule/snapshot.h"
#include "engine/trace/chrome_trace.h"
#include "engine/trace/summary.h"
#include "engine/trace/trace.h"

namespace weft::engine {

/// The run has failed, on all ranks, for the same reason.
class RunFailure : public std::runtime_error {
 public:
  RunFailure(const std::string& what, bool reported, bool network_broken)
      : std::runtime_error(what), reported_(reported), network_broken_(network_broken) {}

  /// On this rank RuntimeOptions::on_failure was called.
  bool reported_here() const { return reported_; }

  /// A rank is dead, or does not answer, or the network fails: Transport::close() would wait for ever,
  /// abandon() is left.
  bool network_broken() const { return network_broken_; }

 private:
  bool reported_;
  bool network_broken_;
};

/// Writes "error: WHAT" to stderr.
void print_failure(const std::string& what);

/// Writes the text to stderr, whole.
void print_state(const std::string& text);

/// How ranks let rank 0 know how far they are while a run lasts. A rank joins what it and its children in a
/// binary tree of the ranks have said last, and says that to its parent: at most one message a rank and
/// period, whatever the number of ranks; rank 0 hears of a rank as many periods late as the tree has levels
/// between. Nobody waits for it, the end of the run does not depend on it, and what is told last may be lost
/// when the run ends. All functions are called by the communication thread, so they should return soon.
struct Bulletins {
  std::chrono::milliseconds period{0};  ///< 0: there are none
  /// On every rank, in every period: how far it is, which takes the place of what it has said before. Empty:
  /// that holds still. Nothing is sent where a rank and those below it have nothing new.
  std::function<Payload()> write;
  std::function<Payload(Payload mine, Payload more)> join;
  /// On rank 0, in every period: of all ranks that it has heard of; empty where they have said nothing.
  std::function<void(Payload)> read;
};

struct RuntimeOptions {
  int threads = 1;  ///< workers of this rank, besides the thread that calls run() and does the communication
  BalancerFactory balancer = work_stealing();
  ExchangeOptions exchange = {};
  TraceOptions trace = {};

  /// What the program gives all handlers of this rank to read (Context::local()); it must outlive the
  /// runtime.
  const void* local = nullptr;

  Bulletins bulletins = {};

  /// A flag that spreads: once it is set on one rank (by a signal, say), it is soon set on all, in this run
  /// or at the beginning of the next. Along a binary tree, by at most three messages of each rank.
  std::atomic<bool>* notice = nullptr;

  /// Takes the copies of snapshots (engine/schedule/snapshot.h); null: there are none. On all ranks or none;
  /// on simulated ones std::logic_error is thrown. Objects that can move are made by the roots of runs only,
  /// and signal no events of the engine. It must outlive the runtime.
  SnapshotSink* snapshots = nullptr;

  /// What users call an object, for request_state(); default "object 3.1".
  std::function<std::string(ObjectId)> name_of = {};
  /// Called by the communication thread with the text that request_state() has asked for.
  std::function<void(const std::string&)> on_state = print_state;

  /// A rank whose process cannot be watched (Transport::watches(): it is on another node) counts as dead
  /// after this silence; the end of another is noticed at once, and stopping it is no death. Time in which
  /// this process was suspended itself does not count.
  std::chrono::milliseconds silence{30'000};
  /// When the run fails, its running handlers have this long to see Context::stop_requested() and return,
  /// and rank 0 to decide what the failure was; then the network is abandoned. That ends the process where
  /// the transport says so; elsewhere run() throws, and ~Runtime() waits for the handlers.
  std::chrono::milliseconds grace{30'000};
  /// Called on one rank as soon as it is certain that the run fails, and why: handlers that go on for long
  /// may keep run() from throwing, or somebody may kill the process first. On more than one when the rank
  /// that was to report does not answer.
  std::function<void(const std::string&)> on_failure = print_failure;
};

/// One rank of a run. Objects live from one run() to the next.
class Runtime {
 public:
  /// `transport` and `registry` must outlive it. All ranks use the same options, but for the number of
  /// threads. One runtime at a time on a transport.
  Runtime(Transport& transport, const Registry& registry, RuntimeOptions options = {});
  ~Runtime();
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  Rank rank() const;
  int ranks() const;

  /// Calls `root` on a worker (it may be different, or empty, on each rank), handles messages, and returns
  /// when no handler runs and no message flies on any rank. All ranks must call it. The calling thread does
  /// the communication. Throws RunFailure on all ranks if a handler throws, a message cannot be read, objects
  /// wait for what will never come, request_stop() is called or a rank dies. The runtime can only be
  /// destroyed then.
  void run(std::function<void(Context&)> root = {});

  /// The same for messages between objects that cannot move, where each rank knows what comes to it: `done`
  /// says whether all of that has been handled here. The communication thread asks it while no handler runs.
  /// Nothing is balanced, and a rank returns when it has had and sent all of its own: others may be in the
  /// run still, or not yet, and hear of this rank's next one when they come to it. A failure later on is
  /// thrown on this rank by the run that it is in then. Where `done` stays false, for a message that nobody
  /// sends or that the network loses, the run goes on until it is stopped or a rank dies.
  void run_until(std::function<bool()> done, std::function<void(Context&)> root);

  /// All ranks stop soon and fail with `reason` (a literal: only the pointer is kept). From any thread or
  /// signal handler.
  void request_stop(const char* reason) noexcept;

  /// RuntimeOptions::on_state is soon given what this rank does: its load, the messages on their way, what
  /// each object here does or waits for, and for whom. Between runs it waits for the next one. From any
  /// thread or signal handler.
  void request_state() noexcept;

  /// Takes the place of RuntimeOptions::bulletins from the next run on, where the ranks first have to agree
  /// on whether there are any. On all ranks, between runs.
  void set_bulletins(Bulletins bulletins);

  /// Visits the objects of type T that are here now, in the order of their ids; not during run().
  template <class T>
  void visit(const std::function<void(MobilePtr<T>, T&)>& function) {
    visit(registry_.type<T>(), [&](ObjectId id, void* object) { function({id}, *static_cast<T*>(object)); });
  }

  /// Before the run that goes on from a snapshot, on whatever ranks: every rank is told where each object
  /// will be, then given the copies of its objects, then the messages for them. Objects keep their ids;
  /// `home` in these need not be a rank any more.
  void restore_location(ObjectId id, Rank at);
  void restore_object(Payload copy);
  void restore_message(Payload copy);

  /// What this rank did in all runs so far.
  RankSummary summary() const;
  /// None where this rank keeps no spans.
  std::optional<RankTimeline> timeline() const;
  /// Nanoseconds to add to this rank's times to get rank 0's, by the latest comparison of their clocks.
  std::int64_t clock_offset() const;

  // At rank 0, up a binary tree by point-to-point messages; elsewhere empty. All ranks must call it.

  /// The summaries of all ranks, summed on the way: rank 0 gets no more than any other.
  RunSummary gather_sums();
  /// The summaries of all ranks, and the timelines of those that keep spans, by rank.
  std::vector<RankSummary> gather_summaries();
  std::vector<RankTimeline> gather_timelines();

 private:
  class Implementation;
  void visit(const TypeInfo& type, const std::function<void(ObjectId, void*)>& function);

  const Registry& registry_;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::engine

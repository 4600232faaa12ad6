// The mobile objects of one rank, the messages that wait for them, and the workers that handle these.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "engine/network/exchange.h"
#include "engine/objects/cell.h"
#include "engine/objects/directory.h"
#include "engine/objects/registry.h"
#include "engine/schedule/cost_model.h"
#include "engine/schedule/helpers.h"
#include "engine/schedule/load.h"
#include "engine/schedule/recent_times.h"
#include "engine/schedule/snapshot.h"
#include "engine/schedule/termination.h"
#include "engine/trace/trace.h"

namespace weft::engine {

class Arena;

/// All state is under one lock: an operation takes well under a microsecond, a handler milliseconds and more.
/// Handlers, packing and sending happen outside it.
class Scheduler {
 public:
  struct Options {
    Rank rank;
    int ranks = 1;
    int threads = 1;
    const void* local = nullptr;   ///< Context::local()
    bool report_finished = false;  ///< keep the objects whose handlers ran for take_finished()
    std::function<std::string(ObjectId)> name_of = {};  ///< RuntimeOptions::name_of
    SnapshotSink* snapshots = nullptr;                  ///< null: there are none
    VirtualTime* virtual_time = nullptr;  ///< of a simulated rank: there are no threads, see work_virtually()
  };

  /// `wake` rouses the communication thread.
  Scheduler(Options options, const Registry& registry, Exchange& exchange, Trace& trace,
            std::function<void()> wake);
  ~Scheduler();

  // --- For handlers, on any thread; see context.h.
  Rank rank() const { return options_.rank; }
  int ranks() const { return options_.ranks; }
  const Registry& registry() const { return registry_; }
  const void* local() const { return options_.local; }
  bool stopping() const { return stopping_.load(std::memory_order_relaxed); }
  const std::atomic<bool>& stop_flag() const { return stopping_; }
  int idle_workers() const;
  ObjectId add_object(const TypeInfo& type, void* object);
  void send(Cell& from, Request request, ObjectId target, std::uint32_t method, std::uint64_t round,
            double expected, Payload payload);
  void declare_event(Cell& self, std::uint32_t method, std::uint64_t round,
                     std::vector<ObjectId> dependencies, double expected);

  // --- For the communication thread.
  /// Lets workers work, first at `root` if there is one.
  void start(std::function<void(Context&)> root);
  /// The run is over: the trace can be read.
  void end_run() { helpers_.end_run(); }

  void receive_task(Rank from, Payload payload, std::size_t wire_bytes);
  void receive_object(Rank from, Payload payload, std::size_t wire_bytes);
  void receive_location(Payload payload);

  /// Packs and sends the objects that are to move and rest; true when there were any.
  bool send_migrants();

  /// Asks an object to move as soon as no worker has it. Nothing happens when it is not here, or cannot move.
  void move(ObjectId id, Rank to);

  /// Of a simulated rank, whose handlers run when this is called: each at once, though it ends, and its
  /// messages leave, when their time has come. True when anything happened.
  bool work_virtually();
  /// When it has to be called next though nothing happens.
  std::optional<TimePoint> next_virtual_step() const;

  Load load() const;
  std::vector<ReadyObject> ready_objects() const;
  int ties(ObjectId id, Rank to) const;
  /// Processor seconds that moving an object takes the ranks; nothing until a few have left.
  std::optional<double> move_seconds() const;
  std::vector<ObjectId> take_finished();
  /// The communication thread is woken whenever objects wait for a worker.
  void wake_when_ready(bool on);

  /// This rank's counts if it is passive: no worker works, nothing waits for one.
  std::optional<WaveCount> passive_count() const;

  /// No handler starts any more.
  void stop();
  bool stopped() const;

  /// Why a handler here failed, if one did.
  std::optional<std::string> failure() const;

  /// Who waits here for what, one a line; empty when nobody does.
  std::vector<std::string> waits() const;

  /// The rank's load, its objects and what each does or waits for, one a line; also while handlers run.
  std::vector<std::string> state() const;

  // --- Snapshots (scheduler_snapshot.cpp), for the communication thread.
  bool root_is_through() const;
  /// Of the objects that can move, those that have been made, or restored, on this rank.
  std::uint64_t movable_objects_made() const;
  void begin_snapshot(std::uint64_t epoch);
  void end_snapshot();
  SnapshotCounts snapshot_counts() const;
  /// Of all workers, in all snapshots.
  TimePoint copying() const { return copying_; }

  // --- Between runs.
  /// Runtime::restore_object(), restore_message(), restore_location().
  void restore_object(Payload copy);
  void restore_message(Payload copy);
  void restore_location(ObjectId id, Rank at);

  /// Calls `visit` with each object of a type that is here, in the order of their ids.
  void visit(const TypeInfo& type, const std::function<void(ObjectId, void*)>& visit);

  std::uint64_t moved_in() const { return moved_in_; }
  std::uint64_t moved_out() const { return moved_out_; }
  std::uint64_t handled() const { return handled_; }
  /// Nanoseconds that workers of simulated ranks waited for cores that they share.
  TimePoint waited_for_cores() const { return waited_for_cores_; }

 private:
  using Lock = std::unique_lock<std::mutex>;

  Cell* find(ObjectId id) const;
  void install(std::unique_ptr<Cell> cell, std::vector<Task> mailbox = {});
  void accept(Cell& cell, Task task);
  void accept_in_order(Cell& cell, Task task);
  void note_waits(Cell& cell);
  void fire(Cell& cell, FiredEvent event);
  void push(Cell& cell, Task task);
  void route(Task task);
  void forward(Task task, const Location& location);
  void consume(Task& task);
  void make_ready(Cell& cell);

  struct CellCopy;
  bool needs_copy(const Cell& cell) const;
  void begin_epoch(std::uint64_t epoch);
  void count_sent(const Envelope& envelope);
  void count_received(const Envelope& envelope);
  void keep_if_between(const Cell& cell, Task& task);
  CellCopy begin_copy(Cell& cell);
  void end_copy(Cell& cell, CellCopy copy);
  void copy_cell(Cell& cell, Lane& lane, Lock& lock);
  static Task copy_of(const Task& task);
  void forget_former_roots();
  void place(PackedCell packed);
  Rank home_of(ObjectId id) const { return Rank(id.home.value % options_.ranks); }
  void dispatch(Task task);

  /// Of a handler that has run. Nanoseconds.
  struct Times {
    TimePoint begin = 0, end = 0;
    TimePoint took = 0;  ///< without what its thread waited for a processor that others had
  };

  /// A handler of a simulated rank that has run; its worker is busy with it until `end`.
  struct VirtualRun {
    Cell* cell = nullptr;  ///< null: the worker is free
    Task task;
    Times times;
    TimePoint own_end = 0;                         ///< when it would have ended on a core of its own
    TimePoint end = 0;                             ///< by VirtualTime::worked()
    std::deque<std::pair<TimePoint, Task>> sends;  ///< likewise when each leaves; ascending
  };
  bool advance(VirtualRun& run, Lane& lane, TimePoint time);
  void begin(VirtualRun& run, Lane& lane);
  void run_virtually(VirtualRun& run, Lane& lane);
  void drop_virtual_runs();

  void dequeued(double seconds, std::size_t messages);
  void check_names(const Envelope& envelope) const;

  void work(Lane& lane);
  void drain(Lane& lane) noexcept;
  void handle_ready(Lane& lane, bool& busy);
  void worker_failed(const char* what) noexcept;
  void quit() noexcept;
  /// Runs `step` of a handler; whatever it throws fails the run.
  template <class Step>
  bool guard(const Cell& cell, const Task& task, const Step& step) {
    try {
      step();
      return true;
    } catch (...) {
      handler_failed(cell, task);
      return false;
    }
  }
  void handler_failed(const Cell& cell, const Task& task);
  Times run(Cell& cell, Task& task, Lane& lane);
  void unpack_if_packed(Cell& cell, const Task& task, Lane& lane);
  void handle(Cell& cell, Task& task);
  void leave(Cell& cell, std::uint64_t to);
  std::unique_ptr<Cell> finish(Cell& cell, const Task& task, const Times& times, Lane& lane);
  void rest(Cell& cell);
  std::unique_ptr<Cell> destroy(Cell& cell);
  std::unique_ptr<Cell> take_out(ObjectId id);
  void send_object(std::unique_ptr<Cell> cell);
  void tell_location(Rank to, ObjectId id, Location location);
  void fail(const std::string& what);
  std::string describe(const Cell& cell, const Task& task) const;
  void describe_waits(const Cell& cell, std::vector<std::string>& lines) const;
  std::string where(ObjectId id) const;
  std::string name_and_place(ObjectId id) const;
  std::string load_line() const;
  std::string state_of(const Cell& cell) const;

  const Options options_;
  const Registry& registry_;
  Exchange& exchange_;
  Trace& trace_;
  const std::function<void()> wake_;
  Helpers helpers_;
  std::unique_ptr<Arena> arena_;

  mutable std::mutex mutex_;
  std::unordered_map<ObjectId, std::unique_ptr<Cell>> cells_;
  Cell root_;
  std::function<void(Context&)> root_function_;
  std::deque<Cell*> ready_;
  Directory directory_;
  CostModel costs_;
  std::unordered_map<ObjectId, std::vector<Task>> parked_;  ///< came before their object
  std::vector<ObjectId> migrating_;
  std::vector<ObjectId> finished_;
  std::uint32_t created_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t received_ = 0;
  std::uint64_t moved_in_ = 0;
  std::uint64_t moved_out_ = 0;
  std::uint64_t handled_ = 0;
  TimePoint waited_for_cores_ = 0;
  RecentTimes packing_;        ///< processor time of objects that have left
  RecentTimes unpacking_;      ///< of objects that have come
  std::uint64_t waiting_ = 0;  ///< objects that wait for an event or hold messages
  std::uint64_t epoch_ = 0;    ///< of the latest snapshot that this rank has heard of
  bool collecting_ = false;    ///< it goes on
  std::uint64_t copied_ = 0;   ///< objects, in this epoch
  std::uint64_t movable_made_ = 0;
  std::vector<ObjectId> restored_;  ///< since the last run
  bool foreign_homes_ = false;      ///< objects were restored that were made on ranks which do not exist here
  std::uint64_t tasks_sent_ = 0, tasks_received_ = 0;            ///< to and from other ranks
  std::uint64_t sent_after_copy_ = 0, received_after_copy_ = 0;  ///< of these, by objects of this epoch
  std::atomic<TimePoint> copying_{0};
  std::condition_variable work_there_;
  int asleep_ = 0;  ///< workers that wait for work
  int busy_ = 0;    ///< workers in a handler
  bool quit_ = false;
  double queued_seconds_ = 0;        ///< predicted, of all messages in mailboxes
  std::size_t queued_messages_ = 0;  ///< in mailboxes
  bool wake_when_ready_ = false;
  std::atomic<bool> stopping_{false};
  std::optional<std::string> failure_;
  std::vector<VirtualRun> virtual_runs_;  ///< by worker; never resized
  VirtualRun* sender_ = nullptr;          ///< of a simulated rank: whose handler runs now
  std::vector<std::thread> workers_;      ///< last: they use all of the above
};

}  // namespace weft::engine

// Accepting, handling and moving.
#include "engine/schedule/scheduler.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

#include "engine/base/arena.h"
#include "engine/base/text.h"
#include "engine/schedule/context.h"
#include "engine/trace/held_up.h"
#include "engine/trace/processor_time.h"

namespace weft::engine {
namespace {

/// On the wire the envelope follows the arguments, so that these need not be moved to make room for it.
Payload to_wire(const Envelope& envelope, Payload payload) {
  const auto* first = reinterpret_cast<const std::byte*>(&envelope);
  payload.bytes.insert(payload.bytes.end(), first, first + sizeof envelope);
  return payload;
}

Task from_wire(Payload payload) {
  Task task;
  if (payload.bytes.size() < sizeof(Envelope)) throw UnpackError("a message is shorter than its envelope");
  const std::size_t size = payload.bytes.size() - sizeof(Envelope);
  std::memcpy(&task.envelope, payload.bytes.data() + size, sizeof(Envelope));
  payload.bytes.resize(size);
  task.payload = std::move(payload);
  return task;
}

Traffic traffic_of(const Envelope& envelope) {
  return envelope.request == Request::signal ? Traffic::signal : Traffic::invoke;
}

}  // namespace

Scheduler::Scheduler(Options options, const Registry& registry, Exchange& exchange, Trace& trace,
                     std::function<void()> wake)
    : options_(options),
      registry_(registry),
      exchange_(exchange),
      trace_(trace),
      wake_(std::move(wake)),
      helpers_(trace),
      arena_(options.virtual_time ? nullptr
                                  : std::make_unique<Arena>(options.threads,
                                                            [this](int slot, bool enters) {
                                                              if (enters)
                                                                helpers_.enters(slot);
                                                              else
                                                                helpers_.leaves(slot);
                                                            })),
      directory_(options.rank),
      costs_(registry.methods()) {
  root_.id = ObjectId{options_.rank, 0};
  if (options_.virtual_time) {
    if (options_.snapshots) throw std::logic_error("simulated ranks take no snapshots");
    virtual_runs_ = std::vector<VirtualRun>(static_cast<std::size_t>(options_.threads));
    return;
  }
  try {
    for (int worker = 0; worker < options_.threads; ++worker) {
      workers_.emplace_back([this, worker] { work(trace_.worker_lane(worker)); });
    }
  } catch (...) {  // the system has no thread left
    quit();
    throw;
  }
}

Scheduler::~Scheduler() { quit(); }

void Scheduler::quit() noexcept {
  stop();
  {
    const Lock lock(mutex_);
    quit_ = true;
  }
  work_there_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

// --- Objects and messages

ObjectId Scheduler::add_object(const TypeInfo& type, void* object) {
  auto cell = std::make_unique<Cell>();
  cell->type = &type;
  cell->object = object;
  const Lock lock(mutex_);
  cell->id = ObjectId{options_.rank, ++created_};
  cell->epoch = epoch_;
  movable_made_ += type.movable;
  const ObjectId id = cell->id;
  install(std::move(cell));
  return id;
}

/// Puts an object in its place, and to it the messages that it brings and those that came before it. Only
/// what is in its place may be in the queue of those that are ready: memory may be short at any step.
void Scheduler::install(std::unique_ptr<Cell> cell, std::vector<Task> mailbox) {
  Cell& installed = *cell;
  cells_.emplace(installed.id, std::move(cell));
  for (Task& task : mailbox) push(installed, std::move(task));
  note_waits(installed);
  if (auto parked = parked_.extract(installed.id)) {
    for (Task& task : parked.mapped()) accept(installed, std::move(task));
  }
  if (installed.state == Cell::State::idle && needs_copy(installed)) make_ready(installed);
}

Cell* Scheduler::find(ObjectId id) const {
  const auto found = cells_.find(id);
  return found == cells_.end() ? nullptr : found->second.get();
}

void Scheduler::send(Cell& from, Request request, ObjectId target, std::uint32_t method, std::uint64_t round,
                     double expected, Payload payload) {
  if (!target.valid() || target.is_root() || (target.home.value >= options_.ranks && !foreign_homes_)) {
    throw std::logic_error("a message is sent to no object");
  }
  if (request == Request::signal && options_.snapshots)
    throw std::logic_error("objects that snapshots are taken of cannot signal events of the engine");
  if (request == Request::migrate && round >= static_cast<std::uint64_t>(options_.ranks)) {
    throw std::logic_error(text("object ", target, " is to move to rank ", static_cast<std::int64_t>(round),
                                ", which does not exist"));
  }
  Task task;
  task.envelope = {target, from.id, 0, round, 0, from.epoch, expected, method, 0, options_.rank, 0, request};
  task.payload = std::move(payload);
  {
    const Lock lock(mutex_);
    task.envelope.sequence = from.outbound[target]++;
    task.envelope.id = static_cast<std::uint64_t>(options_.rank.value) << 40 | ++messages_;
    if (trace_.keeps_spans()) trace_.communication_lane().departure({now(), task.envelope.id, from.lane});
    if (sender_ != nullptr) {
      sender_->sends.emplace_back(now(), std::move(task));
      return;
    }
    dispatch(std::move(task));
  }
  if (options_.virtual_time == nullptr) exchange_.wait_for_room();
}

void Scheduler::dispatch(Task task) {
  const ObjectId target = task.envelope.target;
  if (Cell* cell = find(target)) return accept(*cell, std::move(task));
  if (directory_.is_gone(target, created_)) {
    throw std::logic_error(text("a message is sent to object ", target, ", which was destroyed"));
  }
  if (directory_.is_to_come(target, created_)) {
    parked_[target].push_back(std::move(task));
    return;
  }
  forward(std::move(task), directory_.best_guess(target));
}

void Scheduler::declare_event(Cell& self, std::uint32_t method, std::uint64_t round,
                              std::vector<ObjectId> dependencies, double expected) {
  if (self.type == nullptr)
    throw std::logic_error("a rank's root cannot wait for events: it is no mobile object");
  const Lock lock(mutex_);
  if (auto event = self.events.declare({method, round}, std::move(dependencies), expected)) {
    fire(self, std::move(*event));
  }
  note_waits(self);
}

/// A message has reached its object; it is taken when its turn has come.
void Scheduler::accept(Cell& cell, Task task) {
  keep_if_between(cell, task);
  Cell::Inbound& inbound = cell.inbound[task.envelope.sender];
  if (task.envelope.sequence != inbound.next) {
    consume(task);  // it may wait for one that the window holds back
    inbound.held.emplace(task.envelope.sequence, std::move(task));
    ++cell.held;
    return note_waits(cell);
  }
  accept_in_order(cell, std::move(task));
  ++inbound.next;
  for (auto held = inbound.held.begin(); held != inbound.held.end() && held->first == inbound.next;
       held = inbound.held.erase(held)) {
    accept_in_order(cell, std::move(held->second));
    ++inbound.next;
    --cell.held;
  }
  note_waits(cell);
}

/// Keeps the number of objects that wait for something up to date.
void Scheduler::note_waits(Cell& cell) {
  const bool waits = cell.held > 0 || !cell.events.empty();
  if (waits == cell.waits) return;
  cell.waits = waits;
  waits ? ++waiting_ : --waiting_;
}

void Scheduler::accept_in_order(Cell& cell, Task task) {
  if (task.envelope.request != Request::signal) return push(cell, std::move(task));
  consume(task);
  try {
    auto event = cell.events.arrive({task.envelope.method, task.envelope.round}, task.envelope.sender,
                                    std::move(task.payload));
    if (event) fire(cell, std::move(*event));
  } catch (const std::logic_error& error) {
    fail(text(describe(cell, task), ": ", error.what()));
  }
}

void Scheduler::fire(Cell& cell, FiredEvent event) {
  Task task;
  task.envelope.target = task.envelope.sender = cell.id;
  task.envelope.request = Request::fire;
  task.envelope.method = event.key.method;
  task.envelope.round = event.key.round;
  task.envelope.expected = event.expected;
  task.arrivals = std::move(event.arrivals);
  push(cell, std::move(task));
}

void Scheduler::push(Cell& cell, Task task) {
  const MethodInfo* method = task.info = registry_.find_method(task.envelope.method);
  const bool runs = task.envelope.request == Request::invoke || task.envelope.request == Request::fire;
  task.predicted = method && runs ? costs_.predict(method->index, cell.costs, task.envelope.expected) : 0;
  cell.queued_seconds += task.predicted;
  queued_seconds_ += task.predicted;
  ++queued_messages_;
  cell.mailbox.push_back(std::move(task));
  if (cell.state == Cell::State::idle) make_ready(cell);
}

/// Sums of what was added and taken away again are not exact: without messages there are no seconds.
void Scheduler::dequeued(double seconds, std::size_t messages) {
  queued_messages_ -= messages;
  queued_seconds_ = queued_messages_ == 0 ? 0 : queued_seconds_ - seconds;
}

/// What is short passes what is not, in its order: other objects wait for the messages that it sends, and an
/// object that waits for nobody can wait longer. (Without it all of one kind of step is done before any of
/// the next: workers have too much to do, then too little.)
void Scheduler::make_ready(Cell& cell) {
  constexpr double kShort = 2e-3;  // seconds
  const auto is_short = [](const Cell* c) { return c->type != nullptr && c->queued_seconds < kShort; };
  cell.state = Cell::State::ready;
  const auto place = is_short(&cell) ? std::ranges::find_if_not(ready_, is_short) : ready_.end();
  ready_.insert(place, &cell);
  if (asleep_ > 0) work_there_.notify_one();
  if (wake_when_ready_) wake_();
}

/// Tells the sender that this rank is done with a message.
void Scheduler::consume(Task& task) {
  if (task.from.valid()) exchange_.consumed(task.from, task.wire_bytes);
  task.from = Rank();
}

void Scheduler::forward(Task task, const Location& location) {
  const MethodInfo* method = registry_.find_method(task.envelope.method);
  task.envelope.age = location.age;
  Payload wire = to_wire(task.envelope, std::move(task.payload));
  trace_.communication_lane().sent(task.envelope.hops > 0 ? Traffic::forward : traffic_of(task.envelope),
                                   method ? method->index : Span::kNoName, location.rank, wire.size());
  ++sent_;
  count_sent(task.envelope);
  exchange_.post(location.rank, FrameKind::task, std::move(wire));
}

void Scheduler::receive_task(Rank from, Payload payload, std::size_t wire_bytes) {
  const std::size_t size = payload.size();
  Task task = from_wire(std::move(payload));
  check_names(task.envelope);
  task.from = from;
  task.wire_bytes = wire_bytes;
  const Lock lock(mutex_);
  ++received_;
  count_received(task.envelope);
  const MethodInfo* method = registry_.find_method(task.envelope.method);
  trace_.communication_lane().received(task.envelope.hops > 0 ? Traffic::forward : traffic_of(task.envelope),
                                       method ? method->index : Span::kNoName, from, size);
  route(std::move(task));
}

/// Of what has come over the network: anything else would be written beyond the end of a table.
void Scheduler::check_names(const Envelope& envelope) const {
  const auto exists = [this](Rank rank) { return rank.valid() && rank.value < options_.ranks; };
  // Objects that were restored may have homes of a run on more ranks.
  if (envelope.target.valid() && envelope.sender.valid() && exists(envelope.origin)) return;
  throw UnpackError(text("a message names a rank that does not exist: from object ", envelope.sender,
                         " on rank ", envelope.origin.value, " to object ", envelope.target));
}

void Scheduler::route(Task task) {
  const ObjectId target = task.envelope.target;
  if (Cell* cell = find(target)) {
    if (task.envelope.hops > 0 && task.envelope.origin != options_.rank) {
      tell_location(task.envelope.origin, target, {options_.rank, cell->age});
    }
    return accept(*cell, std::move(task));
  }
  consume(task);
  if (const auto location = directory_.newer(target, task.envelope.age)) {
    ++task.envelope.hops;
    return forward(std::move(task), *location);
  }
  if (directory_.is_gone(target, created_)) {
    return fail(text("a message from object ", task.envelope.sender, " reached rank ", options_.rank.value,
                     " for object ", target, ", which was destroyed"));
  }
  parked_[target].push_back(std::move(task));
}

// --- Moving

void Scheduler::move(ObjectId id, Rank to) {
  const Lock lock(mutex_);
  Cell* cell = find(id);
  if (cell == nullptr || !cell->type->movable || to == options_.rank || cell->leaves_for.valid()) return;
  cell->leaves_for = to;
  if (cell->state != Cell::State::running) migrating_.push_back(id);
}

bool Scheduler::send_migrants() {
  std::vector<std::unique_ptr<Cell>> cells;
  {
    const Lock lock(mutex_);
    for (const ObjectId id : std::exchange(migrating_, {})) {
      if (auto cell = take_out(id)) cells.push_back(std::move(cell));
    }
  }
  for (auto& cell : cells) {
    const std::string name =
        text("moving object ", cell->id, " (", cell->type->name, ") from rank ", options_.rank.value);
    try {
      send_object(std::move(cell));
    } catch (const std::exception& error) {
      throw std::runtime_error(text(name, ": ", error.what()));
    }
  }
  return !cells.empty();
}

/// Removes a resting object from this rank; from now on its messages go where it will be.
std::unique_ptr<Cell> Scheduler::take_out(ObjectId id) {
  Cell* cell = find(id);
  // A worker may have taken it meanwhile; then it leaves when that has finished.
  if (cell == nullptr || cell->state == Cell::State::running || !cell->leaves_for.valid()) return nullptr;
  if (cell->state == Cell::State::ready) ready_.erase(std::find(ready_.begin(), ready_.end(), cell));
  dequeued(cell->queued_seconds, cell->mailbox.size());
  for (Task& task : cell->mailbox) consume(task);
  directory_.learn(id, {cell->leaves_for, cell->age + 1});
  ++sent_;
  ++moved_out_;
  if (cell->waits) --waiting_;
  auto node = cells_.extract(id);
  return std::move(node.mapped());
}

void Scheduler::send_object(std::unique_ptr<Cell> cell) {
  const TimePoint begin = now(), worked = processor_time();
  PackedCell packed;
  packed.id = cell->id;
  packed.type = cell->type->id;
  packed.age = cell->age + 1;
  packed.epoch = cell->epoch;
  packed.object = cell->packed ? std::move(*cell->packed) : cell->type->pack(cell->object);
  for (Task& task : cell->mailbox) packed.mailbox.push_back(std::move(task));
  packed.inbound = std::move(cell->inbound);
  packed.outbound = std::move(cell->outbound);
  packed.events = std::move(cell->events);
  Packer packer(true);
  packer(packed);
  Payload payload = packer.take();
  if (options_.virtual_time) options_.virtual_time->copied(payload.size());
  const TimePoint end = now(), packing = processor_time() - worked;
  {
    const Lock lock(mutex_);
    packing_.add(packing);
    Lane& lane = trace_.communication_lane();
    lane.span({begin, end, cell->id, Span::kNoName, Activity::pack, 0});
    lane.sent(Traffic::migrate, Span::kNoName, cell->leaves_for, payload.size());
  }
  exchange_.post(cell->leaves_for, FrameKind::object, std::move(payload));
}

void Scheduler::receive_object(Rank from, Payload payload, std::size_t wire_bytes) {
  PackedCell packed;
  const std::size_t size = payload.size();
  Unpacker unpacker(std::move(payload));
  unpacker(packed);
  unpacker.finish();
  exchange_.consumed(from, wire_bytes);
  const Lock lock(mutex_);
  ++received_;
  ++moved_in_;
  trace_.communication_lane().received(Traffic::migrate, Span::kNoName, from, size);
  begin_epoch(packed.epoch);  // what it sends is of that one
  // What waits for it may be of a later one, of which this rank has not heard.
  for (const Task& task : packed.mailbox) begin_epoch(task.envelope.epoch);
  for (const auto& [sender, waiting] : packed.inbound)
    for (const auto& [sequence, task] : waiting.held) begin_epoch(task.envelope.epoch);
  directory_.arrived(packed.id);
  const Rank home = home_of(packed.id);
  if (home != options_.rank) tell_location(home, packed.id, {options_.rank, packed.age});
  place(std::move(packed));
}

/// Makes a cell of what has come; under the lock.
void Scheduler::place(PackedCell packed) {
  auto cell = std::make_unique<Cell>();
  cell->id = packed.id;
  cell->type = registry_.find_type(packed.type);
  if (cell->type == nullptr) throw std::runtime_error(text("object ", packed.id, " has a type unknown here"));
  cell->age = packed.age;
  cell->epoch = packed.epoch;
  cell->packed = std::move(packed.object);
  cell->inbound = std::move(packed.inbound);
  cell->outbound = std::move(packed.outbound);
  cell->events = std::move(packed.events);
  for (const auto& [sender, inbound] : cell->inbound) cell->held += inbound.held.size();
  install(std::move(cell), std::move(packed.mailbox));
}

void Scheduler::tell_location(Rank to, ObjectId id, Location location) {
  Packer packer;
  packer(id, location);
  exchange_.post(to, FrameKind::location, packer.take());
}

void Scheduler::receive_location(Payload payload) {
  ObjectId id;
  Location location;
  Unpacker unpacker(std::move(payload));
  unpacker(id, location);
  unpacker.finish();
  if (location.rank.value >= options_.ranks) throw UnpackError(text("there is no ", location.rank));
  const Lock lock(mutex_);
  if (find(id) != nullptr) return;
  if (location.rank.valid()) {
    directory_.learn(id, location);
  } else {
    directory_.destroyed(id);
  }
}

// --- Working

void Scheduler::start(std::function<void(Context&)> root) {
  helpers_.begin_run();
  const Lock lock(mutex_);
  stopping_ = false;
  failure_.reset();
  forget_former_roots();
  root_function_ = std::move(root);
  if (root_function_) make_ready(root_);
  if (!ready_.empty()) work_there_.notify_all();  // objects that were restored
}

/// A worker's life.
void Scheduler::work(Lane& lane) {
  const std::thread::id self = std::this_thread::get_id();
  Lock lock(mutex_);
  while (!quit_) {
    if (stopping_ || ready_.empty()) {
      ++asleep_;
      work_there_.wait(lock);
      --asleep_;
    } else {
      // All that is ready is handled in one visit to the arena; a worker that waits for work leaves its slot
      // to others. Not under the lock: a full arena makes this worker wait for those who may want it.
      lock.unlock();
      arena_->execute([&] {
        // A helper may do it for this worker: what it does so is no help.
        const bool by_helper = std::this_thread::get_id() != self && helpers_.leaves(Arena::slot());
        drain(lane);
        if (by_helper) helpers_.enters(Arena::slot());
      });
      lock.lock();
    }
  }
}

/// Handlers may throw what they like (see guard()); what else fails here is the engine's own memory. It must
/// not end the process, which may be somebody else's.
void Scheduler::drain(Lane& lane) noexcept {
  bool busy = false;
  const char* failure = "a worker has failed";
  try {
    return handle_ready(lane, busy);
  } catch (const std::bad_alloc&) {
    failure = "out of memory";
  } catch (...) {
  }
  const Lock lock(mutex_);
  if (busy) --busy_;
  worker_failed(failure);
}

void Scheduler::worker_failed(const char* what) noexcept {
  try {
    if (!failure_) failure_ = what;
  } catch (const std::bad_alloc&) {
    failure_.emplace();
  }
  stopping_ = true;
  wake_();
}

void Scheduler::handle_ready(Lane& lane, bool& busy) {
  Lock lock(mutex_);
  while (!stopping_ && !ready_.empty()) {
    Cell& cell = *ready_.front();
    ready_.pop_front();
    cell.state = Cell::State::running;
    if (needs_copy(cell)) {
      ++busy_;
      busy = true;
      copy_cell(cell, lane, lock);
      --busy_;
      busy = false;
      rest(cell);
      continue;
    }
    if (cell.type != nullptr && cell.mailbox.empty()) {  // it was to be copied, and the snapshot is over
      rest(cell);
      continue;
    }
    Task task;
    if (cell.type != nullptr) {
      task = std::move(cell.mailbox.front());
      cell.mailbox.pop_front();
      cell.queued_seconds = cell.mailbox.empty() ? 0 : cell.queued_seconds - task.predicted;
      dequeued(task.predicted, 1);
    }
    cell.runs = task.envelope.method;
    cell.runs_since = now();
    cell.lane = trace_.index_of(lane);
    ++busy_;
    busy = true;
    lock.unlock();
    consume(task);
    const Times times = run(cell, task, lane);
    lock.lock();
    --busy_;
    busy = false;
    const std::unique_ptr<Cell> dead = finish(cell, task, times, lane);
    if (dead) {  // freeing a large object takes time
      lock.unlock();
      dead->type->destroy(std::exchange(dead->object, nullptr));
      lock.lock();
    }
  }
  if (busy_ == 0 || ready_.empty()) wake_();  // the run may be over, or this rank ask for work
}

/// By the exception that is being handled.
void Scheduler::handler_failed(const Cell& cell, const Task& task) {
  std::string what;
  try {
    throw;
  } catch (const UnpackError& error) {
    what = text("the message cannot be read: ", error.what());
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
    what = "an exception of unknown type";
  }
  const Lock lock(mutex_);
  fail(text(describe(cell, task), ": ", what));
}

Scheduler::Times Scheduler::run(Cell& cell, Task& task, Lane& lane) {
  unpack_if_packed(cell, task, lane);
  // A helper may have the worker's place: what counts is that of the thread that does it.
  thread_local HeldUpClock clock;
  Times times;
  times.begin = now();
  const TimePoint held_up = clock.until(times.begin);
  handle(cell, task);
  times.end = now();
  times.took = times.end - times.begin - (clock.until(times.end) - held_up);
  return times;
}

void Scheduler::unpack_if_packed(Cell& cell, const Task& task, Lane& lane) {
  if (!cell.packed) return;
  const TimePoint begin = now(), worked = processor_time();
  const bool done = guard(cell, task, [&] {
    Payload packed = std::move(*cell.packed);
    cell.packed.reset();
    if (options_.virtual_time) options_.virtual_time->copied(packed.size());
    cell.object = cell.type->unpack(std::move(packed));
  });
  if (!done) return;
  const TimePoint end = now(), unpacking = processor_time() - worked;
  lane.span({begin, end, cell.id, Span::kNoName, Activity::unpack, 0});
  const Lock lock(mutex_);
  unpacking_.add(unpacking);
}

void Scheduler::handle(Cell& cell, Task& task) {
  Context context(*this, cell);
  guard(cell, task, [&] {
    if (cell.type == nullptr) {
      Arena::isolate([&] { root_function_(context); });
    } else if (cell.object == nullptr && !cell.packed) {
      throw std::runtime_error("the object could not be unpacked");
    } else if (task.envelope.request == Request::destroy) {
      cell.destroyed = true;
    } else if (task.envelope.request == Request::migrate) {
      leave(cell, task.envelope.round);
    } else {
      const MethodInfo* method = task.info;
      if (method == nullptr || method->type != cell.type->id) {
        throw std::runtime_error("the object has no such handler (do all ranks run the same program?)");
      }
      Arena::isolate([&] { method->call(cell.object, context, task); });
    }
  });
}

void Scheduler::leave(Cell& cell, std::uint64_t to) {
  if (!cell.type->movable)
    throw std::logic_error("objects of this type cannot move: they have no serialize()");
  if (to >= static_cast<std::uint64_t>(options_.ranks)) throw std::logic_error(text("there is no rank ", to));
  const Lock lock(mutex_);
  const Rank rank(static_cast<std::int32_t>(to));
  cell.leaves_for = rank == options_.rank ? Rank() : rank;
}

/// Records the handler that has run; returns the object if it was its last.
std::unique_ptr<Cell> Scheduler::finish(Cell& cell, const Task& task, const Times& times, Lane& lane) {
  const MethodInfo* method = task.info;
  const std::uint32_t name = method ? method->index : Span::kNoName;
  lane.span({times.begin, times.end, cell.id, name, Activity::compute, task.envelope.id});
  if (cell.type == nullptr) {
    cell.state = Cell::State::idle;
    root_function_ = nullptr;
    return nullptr;
  }
  ++handled_;
  if (method)
    costs_.measured(name, cell.costs, task.envelope.expected, static_cast<double>(times.took) * 1e-9);
  if (cell.destroyed) return destroy(cell);
  rest(cell);
  if (options_.report_finished) {
    finished_.push_back(cell.id);
    wake_();
  }
  return nullptr;
}

/// A worker is through with it.
void Scheduler::rest(Cell& cell) {
  if (cell.leaves_for.valid()) {
    cell.state = Cell::State::leaving;
    migrating_.push_back(cell.id);
    wake_();
  } else if (cell.mailbox.empty() && !needs_copy(cell)) {
    cell.state = Cell::State::idle;
  } else {
    make_ready(cell);
  }
}

std::unique_ptr<Cell> Scheduler::destroy(Cell& cell) {
  if (!cell.mailbox.empty() || cell.waits) {
    fail(text("object ", cell.id, " (", cell.type->name, ") was destroyed on rank ", options_.rank.value,
              " while ", cell.waits ? "events or messages" : "messages", " waited for it"));
  }
  if (cell.waits) --waiting_;
  dequeued(cell.queued_seconds, cell.mailbox.size());
  directory_.destroyed(cell.id);
  if (home_of(cell.id) != options_.rank) tell_location(home_of(cell.id), cell.id, {Rank(), cell.age});
  return std::move(cells_.extract(cell.id).mapped());
}

// --- Looking from outside

int Scheduler::idle_workers() const {
  const Lock lock(mutex_);
  return std::max(0, options_.threads - busy_ - static_cast<int>(ready_.size()));
}

Load Scheduler::load() const {
  const Lock lock(mutex_);
  return {options_.threads, busy_, ready_.size(), std::max(0.0, queued_seconds_), handled_};
}

/// What it takes here stands for what it takes elsewhere: ranks have objects alike.
std::optional<double> Scheduler::move_seconds() const {
  constexpr std::size_t kEnough = 3;  // one that was long by chance would stop all others for good
  // An array that leaves is handed over as it is; where it comes to it is copied into fresh memory.
  constexpr TimePoint kUnpackingOfPacking = 6;
  const Lock lock(mutex_);
  if (packing_.count() < kEnough) return std::nullopt;
  const TimePoint packing = packing_.median();
  const TimePoint unpacking =
      unpacking_.count() < kEnough ? kUnpackingOfPacking * packing : unpacking_.median();
  return 1e-9 * static_cast<double>(packing + unpacking);
}

/// Not those that are only to be copied: nothing is counted that makes them ready, so that the run may end
/// while they move, and they would be lost.
std::vector<ReadyObject> Scheduler::ready_objects() const {
  const Lock lock(mutex_);
  std::vector<ReadyObject> objects;
  for (const Cell* cell : ready_) {
    if (cell->type == nullptr || cell->mailbox.empty()) continue;
    if (cell->type->movable && !cell->leaves_for.valid()) {
      objects.push_back({cell->id, cell->queued_seconds});
    }
  }
  return objects;
}

int Scheduler::ties(ObjectId id, Rank to) const {
  const Lock lock(mutex_);
  const Cell* cell = find(id);
  if (cell == nullptr) return 0;
  int ties = 0;
  for (const auto& [partner, next] : cell->outbound) {
    if (partner == id) continue;
    const Rank rank = cells_.contains(partner) ? options_.rank : directory_.best_guess(partner).rank;
    ties += (rank == to) - (rank == options_.rank);
  }
  // It has told nobody anything yet; those that were made on one rank may be partners.
  if (cell->outbound.empty()) ties += (id.home == to) - (id.home == options_.rank);
  return ties;
}

std::vector<ObjectId> Scheduler::take_finished() {
  const Lock lock(mutex_);
  return std::exchange(finished_, {});
}

void Scheduler::wake_when_ready(bool on) {
  const Lock lock(mutex_);
  wake_when_ready_ = on;
}

std::optional<WaveCount> Scheduler::passive_count() const {
  const Lock lock(mutex_);
  if (failure_ || busy_ > 0 || !ready_.empty() || !migrating_.empty() || !finished_.empty())
    return std::nullopt;
  return WaveCount{sent_, received_, parked_.size() + waiting_};
}

void Scheduler::stop() {
  stopping_ = true;
  drop_virtual_runs();
  exchange_.release_waiters();
}

bool Scheduler::stopped() const {
  const Lock lock(mutex_);
  return busy_ == 0;
}

std::optional<std::string> Scheduler::failure() const {
  const Lock lock(mutex_);
  return failure_;
}

void Scheduler::fail(const std::string& what) {
  if (!failure_) failure_ = what;
  stopping_ = true;
  wake_();
}

std::string Scheduler::describe(const Cell& cell, const Task& task) const {
  if (cell.type == nullptr) return text("the root function on rank ", options_.rank.value);
  const MethodInfo* method = registry_.find_method(task.envelope.method);
  std::string what = method ? method->name : text("unknown handler ", task.envelope.method);
  if (task.envelope.request == Request::destroy) what = "destruction";
  if (task.envelope.request == Request::migrate) what = "migration";
  return text(what, " of object ", cell.id, " (", cell.type->name, ") on rank ", options_.rank.value);
}

void Scheduler::visit(const TypeInfo& type, const std::function<void(ObjectId, void*)>& visit) {
  std::vector<Cell*> cells;
  for (const auto& [id, cell] : cells_) {
    if (cell->type == &type) cells.push_back(cell.get());
  }
  std::sort(cells.begin(), cells.end(), [](const Cell* a, const Cell* b) { return a->id < b->id; });
  for (Cell* cell : cells) {
    if (cell->packed) {
      Payload packed = std::move(*cell->packed);
      cell->packed.reset();
      cell->object = type.unpack(std::move(packed));
    }
    visit(cell->id, cell->object);
  }
}

}  // namespace weft::engine

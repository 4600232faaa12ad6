// Copies of objects for snapshots, and objects made of them.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "engine/base/text.h"
#include "engine/schedule/scheduler.h"

namespace weft::engine {
namespace {

/// Epochs and numbers of messages begin anew in each run: a message of another one has none.
void forget_former_run(Task& task) { task.envelope.epoch = task.envelope.id = 0; }

}  // namespace

/// All that is not the object itself, as it is when the copy begins: what comes later is kept as a message.
struct Scheduler::CellCopy {
  PackedCell cell;
  std::vector<Task*> mailbox;  ///< they stay where they are while the cell is not handled
};

bool Scheduler::root_is_through() const {
  const Lock lock(mutex_);
  return !root_function_;
}

std::uint64_t Scheduler::movable_objects_made() const {
  const Lock lock(mutex_);
  return movable_made_;
}

bool Scheduler::needs_copy(const Cell& cell) const {
  return collecting_ && cell.type != nullptr && cell.type->movable && cell.epoch < epoch_;
}

void Scheduler::begin_snapshot(std::uint64_t epoch) {
  const Lock lock(mutex_);
  begin_epoch(epoch);
}

/// Also when the first message of a copied object comes before rank 0's word.
void Scheduler::begin_epoch(std::uint64_t epoch) {
  if (options_.snapshots == nullptr || epoch <= epoch_) return;
  epoch_ = epoch;
  collecting_ = true;
  copied_ = sent_after_copy_ = received_after_copy_ = 0;
  for (auto& [id, cell] : cells_) {
    if (cell->state == Cell::State::idle && needs_copy(*cell)) make_ready(*cell);
  }
  wake_();
}

void Scheduler::end_snapshot() {
  const Lock lock(mutex_);
  collecting_ = false;
}

SnapshotCounts Scheduler::snapshot_counts() const {
  const Lock lock(mutex_);
  SnapshotCounts counts{copied_, tasks_sent_ - sent_after_copy_, tasks_received_ - received_after_copy_};
  for (const auto& [id, tasks] : parked_) {  // they have come, but not to their objects
    for (const Task& task : tasks) counts.received -= task.envelope.epoch < epoch_;
  }
  return counts;
}

void Scheduler::count_sent(const Envelope& envelope) {
  ++tasks_sent_;
  sent_after_copy_ += epoch_ > 0 && envelope.epoch == epoch_;
}

void Scheduler::count_received(const Envelope& envelope) {
  begin_epoch(envelope.epoch);
  ++tasks_received_;
  received_after_copy_ += epoch_ > 0 && envelope.epoch == epoch_;
}

/// A message that was sent before its sender was copied, and reaches its object after that was.
void Scheduler::keep_if_between(const Cell& cell, Task& task) {
  if (!collecting_ || cell.epoch != epoch_ || task.envelope.epoch >= epoch_) return;
  if (!cell.type->movable) return;
  Packer packer;
  packer(task);
  options_.snapshots->message(epoch_, packer.take());
}

/// Under the lock. What copied objects have sent already is not part of the copy: it is the last of what each
/// has sent.
Scheduler::CellCopy Scheduler::begin_copy(Cell& cell) {
  CellCopy copy;
  copy.cell.id = cell.id;
  copy.cell.type = cell.type->id;
  copy.cell.age = cell.age;
  copy.cell.epoch = epoch_;
  copy.cell.outbound = cell.outbound;
  for (const auto& [sender, inbound] : cell.inbound) {
    Cell::Inbound& kept = copy.cell.inbound[sender];
    kept.next = inbound.next;
    for (const auto& [sequence, task] : inbound.held) {
      if (task.envelope.epoch < epoch_) kept.held.emplace(sequence, copy_of(task));
    }
  }
  for (Task& task : cell.mailbox) {
    const bool later = task.envelope.epoch >= epoch_;
    if (later) --copy.cell.inbound[task.envelope.sender].next;
    if (!later) copy.mailbox.push_back(&task);
  }
  cell.epoch = epoch_;
  return copy;
}

Task Scheduler::copy_of(const Task& task) {
  Packer packer;
  packer(const_cast<Task&>(task));  // one function packs and unpacks; this packer leaves what it packs
  Task copy;
  Unpacker unpacker(packer.take());
  unpacker(copy);
  return copy;
}

/// Of a cell that this worker has, without the lock.
void Scheduler::end_copy(Cell& cell, CellCopy copy) {
  for (const Task* task : copy.mailbox) copy.cell.mailbox.push_back(copy_of(*task));
  if (cell.packed) {
    Packer packer;
    packer(*cell.packed);
    Unpacker unpacker(packer.take());
    unpacker(copy.cell.object);
  } else {
    copy.cell.object = cell.type->copy(cell.object);
  }
  Packer packer(true);
  packer(copy.cell);
  options_.snapshots->object(copy.cell.epoch, packer.take());
}

/// Instead of a handler: the cell is this worker's.
void Scheduler::copy_cell(Cell& cell, Lane& lane, Lock& lock) {
  const TimePoint begin = now();
  CellCopy copy = begin_copy(cell);
  const std::uint64_t epoch = copy.cell.epoch;
  lock.unlock();
  const bool good = guard(cell, {}, [&] { end_copy(cell, std::move(copy)); });
  const TimePoint end = now();
  lock.lock();
  copied_ += good && epoch == epoch_;  // the next may have begun
  copying_ += end - begin;
  lane.span({begin, end, cell.id, Span::kNoName, Activity::pack, 0});
  wake_();
}

void Scheduler::restore_object(Payload copy) {
  PackedCell packed;
  Unpacker unpacker(std::move(copy));
  unpacker(packed);
  unpacker.finish();
  packed.age = 0;  // ages and epochs begin anew
  packed.epoch = 0;
  for (Task& task : packed.mailbox) forget_former_run(task);
  for (auto& [sender, inbound] : packed.inbound) {
    for (auto& [sequence, task] : inbound.held) forget_former_run(task);
  }
  const Lock lock(mutex_);
  stopping_ = true;  // until the next run starts
  restored_.push_back(packed.id);
  ++movable_made_;
  place(std::move(packed));
}

void Scheduler::restore_message(Payload copy) {
  Task task;
  Unpacker unpacker(std::move(copy));
  unpacker(task);
  unpacker.finish();
  forget_former_run(task);
  const Lock lock(mutex_);
  Cell* cell = find(task.envelope.target);
  if (cell == nullptr)
    throw std::runtime_error(text("a message is for object ", task.envelope.target, ", which is not here"));
  accept(*cell, std::move(task));
}

/// Under the lock, when all has been restored: roots of this run number their messages from 0. Those of the
/// run that the objects come from have all come.
void Scheduler::forget_former_roots() {
  for (const ObjectId id : restored_)
    std::erase_if(find(id)->inbound,
                  [](const auto& from) { return from.first.is_root() && from.second.held.empty(); });
  restored_.clear();
}

void Scheduler::restore_location(ObjectId id, Rank at) {
  const Lock lock(mutex_);
  if (id.home.value >= options_.ranks) foreign_homes_ = true;
  if (id.home == options_.rank) created_ = std::max(created_, id.number);
  if (at != options_.rank) directory_.learn(id, {at, 0});
}

}  // namespace weft::engine

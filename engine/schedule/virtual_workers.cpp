// The workers of a simulated rank: handlers run at once, on the communication thread, and take their time
// afterwards.
#include <algorithm>
#include <exception>
#include <utility>

#include "engine/schedule/scheduler.h"

namespace weft::engine {

bool Scheduler::work_virtually() {
  if (options_.virtual_time == nullptr || stopping_) return false;
  bool any = false;
  const TimePoint time = now();
  for (std::size_t i = 0; i < virtual_runs_.size() && !stopping_; ++i) {
    Lane& lane = trace_.worker_lane(static_cast<int>(i));
    VirtualRun& run = virtual_runs_[i];
    if (run.cell != nullptr) any |= advance(run, lane, time);
    if (run.cell != nullptr || ready_.empty() || stopping_) continue;
    begin(run, lane);
    any = true;
  }
  return any;
}

std::optional<TimePoint> Scheduler::next_virtual_step() const {
  std::optional<TimePoint> next;
  for (const VirtualRun& run : virtual_runs_) {
    if (run.cell == nullptr) continue;
    const TimePoint due = run.sends.empty() ? run.end : std::min(run.end, run.sends.front().first);
    next = std::min(next.value_or(due), due);
  }
  if (next) next = options_.virtual_time->when(*next);
  return next;
}

/// Sends what the handler had sent by `time`, and frees the worker when it is over.
bool Scheduler::advance(VirtualRun& run, Lane& lane, TimePoint time) {
  bool any = false;
  std::unique_ptr<Cell> dead;
  {
    const Lock lock(mutex_);
    const TimePoint worked = options_.virtual_time->worked(time);
    for (; !run.sends.empty() && run.sends.front().first <= worked; run.sends.pop_front(), any = true) {
      try {
        dispatch(std::move(run.sends.front().second));
      } catch (const std::exception& error) {
        fail(describe(*run.cell, run.task) + ": " + error.what());
      }
    }
    if (run.end > worked || !run.sends.empty()) return any;
    --busy_;
    run.times.end = std::min(time, options_.virtual_time->when(run.end));
    waited_for_cores_ += std::max<TimePoint>(0, run.times.end - run.own_end);
    dead = finish(*run.cell, run.task, run.times, lane);
    run = {};
  }
  options_.virtual_time->workers_run(-1);
  return true;
}

/// Takes the next object that is ready, and runs its handler.
void Scheduler::begin(VirtualRun& run, Lane& lane) {
  {
    const Lock lock(mutex_);
    Cell& cell = *ready_.front();
    ready_.pop_front();
    cell.state = Cell::State::running;
    if (cell.type != nullptr) {
      run.task = std::move(cell.mailbox.front());
      cell.mailbox.pop_front();
      cell.queued_seconds = cell.mailbox.empty() ? 0 : cell.queued_seconds - run.task.predicted;
      dequeued(run.task.predicted, 1);
    }
    cell.runs = run.task.envelope.method;
    cell.runs_since = now();
    cell.lane = trace_.index_of(lane);
    run.cell = &cell;
    ++busy_;
  }
  consume(run.task);
  run_virtually(run, lane);
}

void Scheduler::run_virtually(VirtualRun& run, Lane& lane) {
  sender_ = &run;
  const TimePoint took =
      options_.virtual_time->run_handler([&] { run.times = this->run(*run.cell, run.task, lane); });
  sender_ = nullptr;
  const TimePoint begin = now();
  const TimePoint worked = options_.virtual_time->worked(begin);
  for (auto& [time, task] : run.sends) time += worked - begin;
  run.end = worked + took;
  run.own_end = begin + took;
  options_.virtual_time->workers_run(1);
}

/// The run fails: what handlers would still have sent is of no interest.
void Scheduler::drop_virtual_runs() {
  for (VirtualRun& run : virtual_runs_) {
    if (run.cell == nullptr) continue;
    run.cell->state = Cell::State::idle;
    --busy_;
    options_.virtual_time->workers_run(-1);
    run = {};
  }
}

}  // namespace weft::engine
